"""Connection to the board: client, byte ports, the virtual rig, the host firmware."""
