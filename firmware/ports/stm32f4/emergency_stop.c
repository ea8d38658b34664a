/* Never run on hardware. */
#include "emergency_stop.h"

#include "pins.h"

#define RELEASE_PORT GPIOB
#define RELEASE_PIN 1u
#define SENSE_PORT GPIOA
#define SENSE_PIN 6u
#define FUNCTION_TIM1_BREAK 1u

void emergency_stop_start(void)
{
    outputs_cut();
    pin_set_mode(RELEASE_PORT, RELEASE_PIN, PIN_OUTPUT);
    pin_pull_up(SENSE_PORT, SENSE_PIN);
    pin_set_alternate(SENSE_PORT, SENSE_PIN, FUNCTION_TIM1_BREAK); /* still readable */
}

void outputs_release(void)
{
    pin_set_high(RELEASE_PORT, RELEASE_PIN);
}

void outputs_cut(void)
{
    pin_set_low(RELEASE_PORT, RELEASE_PIN);
}

bool emergency_stop_is_pressed(void)
{
    return (SENSE_PORT->IDR & (1u << SENSE_PIN)) != 0u;
}
