/* Constants of the core, the same on every board. hal.h contains those of a board. */
#ifndef HB_CONFIG_H
#define HB_CONFIG_H

#define HB_FIRMWARE "hbench-core 0.1" /* at most 16 characters */

#define HB_MAX_STEPS 128u
#define HB_MAX_SEGMENTS 104u
#define HB_MAX_TIME_S 100000.0f /* so that times in ticks fit 32 bits */
#define HB_MAX_FORCE_RATE_N_S 1e9f /* so that its ramp stays finite */

#endif
