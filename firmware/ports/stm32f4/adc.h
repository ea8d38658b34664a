/* ADC1 and ADC2 with DMA. Timer 3 starts 16 scans in each tick, evenly spaced; each scan converts
 * the eight inputs once, four on each ADC at the same time. The sum of the 16 conversions of an
 * input is exactly their mean in 1/16 of a count. The DMA writes the conversions of the present tick
 * while the processor reads those of the last one. Never run on hardware.
 *
 * A scan takes 4 x 27 clocks of 21 MHz = 5.1 us, of which an input is sampled for 0.7 us. The
 * conversions of a word are on average 50 us old at its tick. */
#ifndef STM32F4_ADC_H
#define STM32F4_ADC_H

#include "hal.h"
#include "timer.h"

/* 12 bits; an input's offset is below 16 counts. */
#define ADC_FULL_SCALE (16u * 4095u)
#define ADC_SCALE {.full_scale = ADC_FULL_SCALE, .margin = 16u * 16u}

#define ADC_CONVERTERS 2u
#define ADC_INPUTS (HB_INPUTS / ADC_CONVERTERS) /* of a converter */
#define ADC_CONVERSIONS (TIMER_SCANS * ADC_INPUTS)

/* Two halves of each converter's buffer; the DMA writes to one while the other is read. */
extern volatile uint16_t adc_conversions[2][ADC_CONVERTERS][ADC_CONVERSIONS];

/* Before timer_start_ticks. */
void adc_start(void);

/* Reads the words of the last tick. False: a conversion is missing, and the one before takes its
 * place. That is no failure in a tick after a late one, in which the DMA may not have changed
 * halves; for two ticks in a row it means that the converters or the DMA have stopped. */
bool adc_read(hb_u16 words[HB_INPUTS]);

#endif
