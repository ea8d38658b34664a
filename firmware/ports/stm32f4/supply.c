/* Never run on hardware. */
#include "supply.h"

#include "registers.h"

void supply_start(void)
{
    PWR_CR |= PWR_CR_PLS_HIGHEST;
    PWR_CR |= PWR_CR_PVDE;
    EXTI_RTSR |= EXTI_LINE_SUPPLY; /* the monitor's output rises as the supply falls */
    EXTI_IMR |= EXTI_LINE_SUPPLY;
    NVIC_ISER[IRQ_SUPPLY / 32] = 1u << (IRQ_SUPPLY % 32);
}

bool supply_is_low(void)
{
    return (PWR_CSR & PWR_CSR_PVDO) != 0u;
}
