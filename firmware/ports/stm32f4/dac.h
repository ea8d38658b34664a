/* Valve outputs. Two files implement this header: dac_ad5724r.c for an Analog Devices AD5724R, and
 * dac_onchip.c for the chip's own converters. Never run on hardware. */
#ifndef STM32F4_DAC_H
#define STM32F4_DAC_H

#include "hal.h"

#define DAC_SCALE {.range_v = 10.0f, .codes_per_v = 204.8f, .code_min = -2048, .code_max = 2047}

/* Sets all outputs to neutral. Works at any clock. False: the outputs accept no codes. */
bool dac_start(void);

/* False: the outputs accept no codes. */
bool dac_write(const hb_i16 codes[HB_VALVES]);

/* Sets the outputs to neutral, in any state. */
void dac_clear(void);

#endif
