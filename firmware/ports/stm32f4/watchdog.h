/* Independent watchdog, clocked by its own oscillator of 17 to 47 kHz. Never run on hardware. */
#ifndef STM32F4_WATCHDOG_H
#define STM32F4_WATCHDOG_H

/* It resets the chip 6.8 to 18.8 ms after the last service, and can't be stopped. */
void watchdog_start(void);
void watchdog_service(void);

#endif
