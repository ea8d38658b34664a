/* Never run on hardware. */
#include "clock.h"

#include "registers.h"

/* The Nucleo's ST-Link drives OSC_IN with 8 MHz. 8 MHz / 8 x 336 / 2 = 168 MHz, the highest rate of
 * an F405, and of an F446 without over-drive. */
#define PLL (RCC_PLLCFGR_M(8u) | RCC_PLLCFGR_N(336u) | RCC_PLLCFGR_P_2 | RCC_PLLCFGR_HSE \
             | RCC_PLLCFGR_Q(7u) | RCC_PLLCFGR_R(2u))
#define READS 200000u /* of a flag before it is given up: some 100 ms at 16 MHz */

const char clock_board[] = "stm32f4";
const uint32_t clock_timer_hz = 2u * CLOCK_APB1_HZ; /* timers count at twice a divided APB1 */

void clock_enable_peripherals(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIOA | RCC_AHB1_GPIOB | RCC_AHB1_GPIOC | RCC_AHB1_DMA2;
    RCC->APB1ENR |= RCC_APB1_TIM2 | RCC_APB1_TIM3 | RCC_APB1_TIM5 | RCC_APB1_SPI2
                    | RCC_APB1_USART2 | RCC_APB1_PWR | RCC_APB1_DAC;
    RCC->APB2ENR |= RCC_APB2_TIM1 | RCC_APB2_ADC1 | RCC_APB2_ADC2;
    (void)RCC->APB2ENR; /* the clocks run two cycles after the write */
}

static bool becomes(reg *address, uint32_t mask, uint32_t value)
{
    for (uint32_t i = 0; i < READS; i++) {
        if ((*address & mask) == value) {
            return true;
        }
    }
    return false;
}

bool clock_start(void)
{
    RCC->CR |= RCC_CR_HSEBYP;
    RCC->CR |= RCC_CR_HSEON;
    if (!becomes(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY)) {
        return false;
    }
    RCC->PLLCFGR = PLL;
    RCC->CR |= RCC_CR_PLLON;
    if (!becomes(&RCC->CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY)) {
        return false;
    }
    FLASH_ACR = FLASH_ACR_LATENCY_5 | FLASH_ACR_PREFETCH | FLASH_ACR_INSTRUCTION_CACHE
                | FLASH_ACR_DATA_CACHE;
    if (!becomes(&FLASH_ACR, FLASH_ACR_LATENCY, FLASH_ACR_LATENCY_5)) {
        return false;
    }
    RCC->CFGR = RCC_CFGR_PPRE1_4 | RCC_CFGR_PPRE2_2 | RCC_CFGR_SW_PLL;
    if (!becomes(&RCC->CFGR, RCC_CFGR_SWS, RCC_CFGR_SWS_PLL)) {
        return false;
    }
    RCC->CR |= RCC_CR_CSSON; /* loss of the 8 MHz raises NMI, which stops the board */
    return true;
}
