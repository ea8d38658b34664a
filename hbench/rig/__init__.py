"""The board and the line to it: client, byte ports, the virtual rig, the host firmware."""
