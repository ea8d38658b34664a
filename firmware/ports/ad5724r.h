/* Words of an Analog Devices AD5724R, of 24 bits: upper 8 bits, lower 16 bits. Its channels A, B, C
 * drive T, L1, L2 at +-10 V. */
#ifndef HB_AD5724R_H
#define HB_AD5724R_H

#include "hal.h"

#define DAC_REGISTER 0x00u /* | channel */
#define DAC_RANGE 0x08u    /* | channel */
#define DAC_POWER 0x10u
#define DAC_CONTROL 0x19u
#define DAC_CLEAR 0x1Cu
#define ALL_CHANNELS 0x04u
#define PLUS_MINUS_10_V 0x0004u
#define POWER_A_B_C_REFERENCE 0x0017u /* bit 4, the internal reference: check */
#define CLEAR_TO_0_V 0x0000u

#define POWER_UP_US 200u /* at least 10 us, and the settling of the reference: check */

HB_ASSERT(valves_are_the_first_channels, HB_VALVE_T == 0 && HB_VALVE_L1 == 1 && HB_VALVE_L2 == 2);

#endif
