"""STM32F4: ELF images and the serial boot ROM, which writes the flash."""
