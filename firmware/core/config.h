/* What is fixed when the core is compiled. */
#ifndef HB_CONFIG_H
#define HB_CONFIG_H

#include "dictionary.h"
#include "types.h"

#define HB_FIRMWARE "hbench-core 0.1" /* at most 16 characters */

#define HB_RATE_HZ 10000u
#define HB_PERIOD_S 1e-4f

#define HB_MAX_STEPS 128u
#define HB_MAX_SEGMENTS 128u
#define HB_MAX_TIME_S 100000.0f /* so that times fit 32 bits in ticks */

/* The ring takes 1024 x 15 = 15360 words of 16 bits; L4 to L7 of an F28335 have 16384.
 * A power of two, so that a record's slot is its number's low bits. */
#define HB_LOG_RECORDS 1024u

HB_ASSERT(ring_is_a_power_of_two, (HB_LOG_RECORDS & (HB_LOG_RECORDS - 1u)) == 0u);
HB_ASSERT(ring_fits_l4_to_l7, HB_LOG_RECORDS * HB_RECORD_WORDS <= 16384u);

/* Converter words: the mean of a tick's conversions in 1/16 of an ADC count. */
#define HB_ADC_FULL_SCALE 65520u /* 4095 counts */
#define HB_ADC_MARGIN 256u       /* 16 counts, a converter's own offset */

/* Valves, in the order of the DAC's channels: an AD5724R, 12 bits, +-10 V. */
enum hb_valve { HB_VALVE_T = 0, HB_VALVE_L1 = 1, HB_VALVE_L2 = 2, HB_VALVES = 3 };
#define HB_DAC_RANGE_V 10.0f
#define HB_DAC_CODES_PER_V 204.8f
#define HB_DAC_MIN (-2048)
#define HB_DAC_MAX 2047

#endif
