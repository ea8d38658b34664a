"""A bench that shares nothing with hbench: own equations, controller, logger and file format."""
