/* AD5724R for the valve amplifiers: 24-bit words over McBSP-A as SPI. Never compiled by TI's
 * compiler.
 *
 * Channels A, B, C drive T, L1, L2 at +-10 V. Wiring: MDXA GPIO20 to SDIN, MCLKXA GPIO22 to SCLK,
 * MFSXA GPIO23 to SYNC, LDAC low, BIN/2sCOMP low (codes are two's complement), and GPIO6 to CLR
 * with a pull-down, which holds the outputs at 0 V from reset until hb_dac_start has run. */
#ifndef HB_DAC_H
#define HB_DAC_H

#include "hal.h"

#define HB_DAC_SCALE \
    {.range_v = 10.0f, .codes_per_v = 204.8f, .code_min = -2048, .code_max = 2047}

/* Sets all outputs to neutral in any state of the DAC; CLR stays low. Works at any clock. False:
 * the McBSP does not accept words. */
bool hb_dac_start(void);
/* Sets CLR high. */
void hb_dac_release(void);

/* False: the McBSP does not accept words. */
bool hb_dac_write(const hb_i16 codes[HB_VALVES]);

/* Sets the outputs to neutral by CLR, by the CLEAR command and by neutral codes. */
void hb_dac_clear(void);

#endif
