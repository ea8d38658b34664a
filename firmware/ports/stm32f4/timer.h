/* Timers: 2 is the 10 kHz control interrupt, 3 starts the scans of the ADC, 5 counts time; the
 * processor's own timer supervises them. Never run on hardware. */
#ifndef STM32F4_TIMER_H
#define STM32F4_TIMER_H

#include <stdbool.h>
#include <stdint.h>

#define TIMER_SCANS 16u /* of the ADC in each tick */

/* Starts the counter of time. */
void timer_start(void);
/* Counts at clock_timer_hz, and wraps at 2^32. */
uint32_t timer_now(void);
/* A time in counts. */
uint32_t timer_counts(uint32_t microseconds);
void timer_wait(uint32_t microseconds);

/* Starts the supervision: an interrupt each millisecond, by the processor's own timer. */
void timer_start_supervision(void);

/* Starts the ticks, in step with the scans of the ADC. */
void timer_start_ticks(void);
/* At the begin of the control interrupt: clears the tick. */
void timer_take_tick(void);
/* The next tick has begun since timer_take_tick. */
bool timer_tick_passed(void);

/* The control interrupt alone; the others stay enabled. */
void timer_mask(void);
void timer_unmask(void);

#endif
