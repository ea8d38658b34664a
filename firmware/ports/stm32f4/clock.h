/* Clocks of the chip. Two files implement this header: clock.c for the chip, emulated.c for QEMU.
 * They are the only difference between the two images. Never run on hardware. */
#ifndef STM32F4_CLOCK_H
#define STM32F4_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

extern const char clock_board[]; /* the name that the board reports to the host */

/* Rate at which timers 2, 3 and 5 count. */
extern const uint32_t clock_timer_hz;
#define CLOCK_CPU_HZ 168000000u
#define CLOCK_APB1_HZ 42000000u /* USART2 and SPI2 */

/* Enables the peripherals' clocks. The processor runs at 16 MHz until clock_start. */
void clock_enable_peripherals(void);

/* Processor at 168 MHz from the board's 8 MHz. False: no such clock, or no lock of the PLL. */
bool clock_start(void);

#endif
