"""F28335: boot images of hex2000 and the serial boot ROM, which loads the RAM."""
