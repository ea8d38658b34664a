"""The oil: its record, and its viscosity over temperature."""
