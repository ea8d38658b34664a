/* ePWM1 as the time base of 10 kHz, and the ADC that it starts. Never compiled by TI's compiler.
 *
 * The bench's seven sensors are on ADCINA0 to A6 in the order of the dictionary. One pass of the
 * sequencer has 16 slots, so each sensor twice (and ADCINA7 twice, unused: a full pass ends where
 * it began, so a start too many shifts no channel). Eight passes make 16 conversions of each
 * sensor; their sum is the mean in 1/16 of a count, exactly.
 *
 * Time: 8 x 16 x 80 ns = 10.2 us of conversions, some 15 us with the reading (reckoned, not
 * measured). 64 conversions of each sensor take the ADC 36 us, but would hold the processor for
 * longer than that: the sequencer keeps 16 results. They need DMA, which this port doesn't use. */
#ifndef HB_ADC_H
#define HB_ADC_H

#include "hal.h"

/* 12 bits; an input's offset is below 16 counts. */
#define HB_ADC_FULL_SCALE (16u * 4095u)
#define HB_ADC_SCALE {.full_scale = HB_ADC_FULL_SCALE, .margin = 16u * 16u}

/* Takes 5 ms. */
void hb_adc_start(void);
/* The time base runs, and with it the control interrupt. */
void hb_ticks_start(void);

/* From the control interrupt, after the pass that the time base began: the seven words. False: the
 * ADC doesn't convert. */
bool hb_adc_read(hb_u16 words[HB_SENSORS]);

/* The next tick has begun since hb_adc_read was entered. */
bool hb_tick_passed(void);

#endif
