"""The bench as a simulation: parameters, friction, valves, cylinders, sensors, plant."""
