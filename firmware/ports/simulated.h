/* Converters of the ports whose bench is simulated: ADC of 12 bits, DAC of 12 bits over +-10 V. */
#ifndef HB_SIMULATED_H
#define HB_SIMULATED_H

#define HB_SIMULATED_ADC {.full_scale = 16u * 4095u, .margin = 16u * 16u}
#define HB_SIMULATED_DAC \
    {.range_v = 10.0f, .codes_per_v = 204.8f, .code_min = -2048, .code_max = 2047}

#endif
