/* The firmware on the STM32F4: start, control interrupt, idle loop. Never run on hardware. */
#ifndef STM32F4_BOARD_H
#define STM32F4_BOARD_H

/* After the reset; does not return. The outputs are cut until all parts of the board have started. */
void board_run(void);

void board_control_interrupt(void);

/* Each millisecond: stops the board if the control interrupt does not begin any more. */
void board_supervision_interrupt(void);

/* Cuts the outputs and waits for the reset by the watchdog. Needs no stack of its caller. */
void board_stop(void);

#endif
