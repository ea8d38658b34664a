/* ePWM1 as the 10 kHz time base, and the ADC that it triggers. Never compiled by TI's compiler.
 *
 * The eight inputs are on ADCINA0 to A7 in the order of the dictionary. A pass of the sequencer
 * has 16 slots: each input twice. A full pass ends where it began, so an additional start shifts
 * no channel. Eight passes make 16 conversions of each input; their sum is exactly the mean in
 * 1/16 of a count.
 *
 * Time: 8 x 16 x 80 ns = 10.2 us of conversions, about 15 us with reading (calculated, not
 * measured). 64 conversions of each input would take the ADC 41 us and the processor longer,
 * because the sequencer stores 16 results only. They require DMA, which this port does not use. */
#ifndef HB_ADC_H
#define HB_ADC_H

#include "hal.h"

/* 12 bits; an input's offset is below 16 counts. */
#define HB_ADC_FULL_SCALE (16u * 4095u)
#define HB_ADC_SCALE {.full_scale = HB_ADC_FULL_SCALE, .margin = 16u * 16u}

/* Takes 5 ms. */
void hb_adc_start(void);
/* Starts the time base, and with it the control interrupt. */
void hb_ticks_start(void);

/* Reads the eight words, from the control interrupt after the pass that the time base started.
 * False: the ADC does not convert. */
bool hb_adc_read(hb_u16 words[HB_INPUTS]);

/* The next tick has begun since the start of hb_adc_read. */
bool hb_tick_passed(void);

#endif
