/* The chip's own outputs of 0 to 3.3 V: T on PA4 (DAC 1), L1 on PA5 (DAC 2), L2 on PA8 (pulse width
 * of timer 1, 41 kHz, to be filtered). Half of the range is neutral. Amplifiers make +-10 V of it,
 * behind switches that the released line closes (see emergency_stop.h): without it a valve has
 * 0 V, whatever these pins do. Never run on hardware. */
#include "dac.h"
#include "pins.h"

#define NEUTRAL 2048u
#define CODES 4096u
#define FUNCTION_TIM1 1u
#define PWM_PIN 8u

HB_ASSERT(outputs_are_t_l1_l2, HB_VALVE_T == 0 && HB_VALVE_L1 == 1 && HB_VALVE_L2 == 2);

static uint32_t unsigned_code(hb_i16 code)
{
    return (uint32_t)(code + (hb_i16)NEUTRAL);
}

static void write(uint32_t t, uint32_t l1, uint32_t l2)
{
    DAC_DHR12RD = l1 << 16 | t;
    TIM1->CCR1 = l2;
}

bool dac_start(void)
{
    pin_set_mode(GPIOA, 4u, PIN_ANALOG);
    pin_set_mode(GPIOA, 5u, PIN_ANALOG); /* no longer the Nucleo's LED */
    write(NEUTRAL, NEUTRAL, NEUTRAL);
    DAC_CR = DAC_CR_EN1 | DAC_CR_EN2 | DAC_CR_UNBUFFERED; /* the buffer ends 0.2 V from the rails */

    TIM1->ARR = CODES - 1u;
    TIM1->CCMR1 = TIM_CCMR1_OC1_PWM | TIM_CCMR1_OC1PE;
    TIM1->CCER = TIM_CCER_CC1E;
    /* The emergency stop's sense input switches the output to its inactive level in hardware; only
     * a reset switches it on again. */
    TIM1->BDTR = TIM_BDTR_BKE | TIM_BDTR_BKP | TIM_BDTR_OSSI | TIM_BDTR_MOE;
    TIM1->EGR = TIM_EGR_UG;
    TIM1->CR1 = TIM_CR1_CEN;
    pin_set_alternate(GPIOA, PWM_PIN, FUNCTION_TIM1);
    return true;
}

bool dac_write(const hb_i16 codes[HB_VALVES])
{
    write(unsigned_code(codes[HB_VALVE_T]), unsigned_code(codes[HB_VALVE_L1]),
          unsigned_code(codes[HB_VALVE_L2]));
    return true;
}

void dac_clear(void)
{
    write(NEUTRAL, NEUTRAL, NEUTRAL);
}
