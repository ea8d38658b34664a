/* Addresses and bits of the STM32F4's registers that this port uses, the same on the F405, F407 and
 * F446. Never run on hardware.
 *
 * Sources: ST's reference manuals RM0390 (F446) and RM0090 (F405, F407); Armv7-M Architecture
 * Reference Manual for the registers of the core. */
#ifndef STM32F4_REGISTERS_H
#define STM32F4_REGISTERS_H

#include <stdint.h>

typedef volatile uint32_t reg;

/* Reset and clock control */
typedef struct {
    reg CR, PLLCFGR, CFGR, CIR;
    reg AHB1RSTR, AHB2RSTR, AHB3RSTR, reserved0;
    reg APB1RSTR, APB2RSTR, reserved1[2];
    reg AHB1ENR, AHB2ENR, AHB3ENR, reserved2;
    reg APB1ENR, APB2ENR;
} rcc_registers;
#define RCC ((rcc_registers *)0x40023800u)
#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_HSEBYP (1u << 18)
#define RCC_CR_CSSON (1u << 19)
#define RCC_CR_PLLON (1u << 24)
#define RCC_CR_PLLRDY (1u << 25)
#define RCC_PLLCFGR_M(m) (m)
#define RCC_PLLCFGR_N(n) ((n) << 6)
#define RCC_PLLCFGR_P_2 (0u << 16)
#define RCC_PLLCFGR_HSE (1u << 22)
#define RCC_PLLCFGR_Q(q) ((q) << 24)
#define RCC_PLLCFGR_R(r) ((r) << 28) /* F446 only; reserved on the others */
#define RCC_CFGR_SW 3u
#define RCC_CFGR_SW_PLL 2u
#define RCC_CFGR_SWS (3u << 2)
#define RCC_CFGR_SWS_PLL (2u << 2)
#define RCC_CFGR_PPRE1_4 (5u << 10)
#define RCC_CFGR_PPRE2_2 (4u << 13)
#define RCC_AHB1_GPIOA (1u << 0)
#define RCC_AHB1_GPIOB (1u << 1)
#define RCC_AHB1_GPIOC (1u << 2)
#define RCC_AHB1_DMA2 (1u << 22)
#define RCC_APB1_TIM2 (1u << 0)
#define RCC_APB1_TIM3 (1u << 1)
#define RCC_APB1_TIM5 (1u << 3)
#define RCC_APB1_SPI2 (1u << 14)
#define RCC_APB1_USART2 (1u << 17)
#define RCC_APB1_PWR (1u << 28)
#define RCC_APB1_DAC (1u << 29)
#define RCC_APB2_TIM1 (1u << 0)
#define RCC_APB2_ADC1 (1u << 8)
#define RCC_APB2_ADC2 (1u << 9)

/* Flash interface and power control */
#define FLASH_ACR (*(reg *)0x40023C00u)
#define FLASH_ACR_LATENCY 0xFu
#define FLASH_ACR_LATENCY_5 5u
#define FLASH_ACR_PREFETCH (1u << 8)
#define FLASH_ACR_INSTRUCTION_CACHE (1u << 9)
#define FLASH_ACR_DATA_CACHE (1u << 10)
#define PWR_CR (*(reg *)0x40007000u)
#define PWR_CSR (*(reg *)0x40007004u)
#define PWR_CR_PVDE (1u << 4)
#define PWR_CR_PLS_HIGHEST (7u << 5) /* about 2.9 V */
#define PWR_CSR_PVDO (1u << 2)

/* General-purpose pins */
typedef struct {
    reg MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFR[2];
} gpio_registers;
#define GPIOA ((gpio_registers *)0x40020000u)
#define GPIOB ((gpio_registers *)0x40020400u)
#define GPIOC ((gpio_registers *)0x40020800u)

/* Timers; 2 and 5 have 32 bits, 1 and 3 have 16 */
typedef struct {
    reg CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, RCR;
    reg CCR1, CCR2, CCR3, CCR4, BDTR;
} timer_registers;
#define TIM1 ((timer_registers *)0x40010000u)
#define TIM2 ((timer_registers *)0x40000000u)
#define TIM3 ((timer_registers *)0x40000400u)
#define TIM5 ((timer_registers *)0x40000C00u)
#define TIM_CR1_CEN 1u
#define TIM_CR2_TRGO_AT_UPDATE (2u << 4)
#define TIM_DIER_UIE 1u
#define TIM_SR_UIF 1u
#define TIM_EGR_UG 1u
#define TIM_CCMR1_OC1_PWM (6u << 4) /* active while the counter is below CCR1 */
#define TIM_CCMR1_OC1PE (1u << 3)
#define TIM_CCER_CC1E 1u
#define TIM_BDTR_OSSI (1u << 10)    /* outputs inactive, not floating, while off */
#define TIM_BDTR_BKE (1u << 12)
#define TIM_BDTR_BKP (1u << 13)     /* break at a high level */
#define TIM_BDTR_MOE (1u << 15)

/* Converters from analogue */
typedef struct {
    reg SR, CR1, CR2, SMPR1, SMPR2, JOFR[4], HTR, LTR, SQR1, SQR2, SQR3, JSQR, JDR[4], DR;
} adc_registers;
#define ADC1 ((adc_registers *)0x40012000u)
#define ADC2 ((adc_registers *)0x40012100u)
#define ADC_CCR (*(reg *)0x40012304u)
#define ADC_CCR_PCLK2_BY_4 (1u << 16)
#define ADC_CR1_SCAN (1u << 8)
#define ADC_CR2_ADON 1u
#define ADC_CR2_DMA (1u << 8)
#define ADC_CR2_DDS (1u << 9)           /* DMA requests for ever */
#define ADC_CR2_EXTSEL_TIM3_TRGO (8u << 24)
#define ADC_CR2_EXTEN_RISING (1u << 28)
#define ADC_SMPR_15_CYCLES 1u
#define ADC_SQR1_L(conversions) (((conversions) - 1u) << 20)

/* DMA2: ADC1 is channel 0 of stream 0, ADC2 is channel 1 of stream 2 */
typedef struct {
    reg CR, NDTR, PAR, M0AR, M1AR, FCR;
} dma_stream_registers;
#define DMA2_STREAM0 ((dma_stream_registers *)0x40026410u)
#define DMA2_STREAM2 ((dma_stream_registers *)0x40026440u)
#define DMA_CR_EN 1u
#define DMA_CR_CIRC (1u << 8)
#define DMA_CR_MINC (1u << 10)
#define DMA_CR_PSIZE_16 (1u << 11)
#define DMA_CR_MSIZE_16 (1u << 13)
#define DMA_CR_PRIORITY_HIGH (2u << 16)
#define DMA_CR_DBM (1u << 18)
#define DMA_CR_CT (1u << 19) /* the DMA writes to M1AR now */
#define DMA_CR_CHANNEL(n) ((n) << 25)

/* Converters to analogue */
#define DAC_CR (*(reg *)0x40007400u)
#define DAC_DHR12RD (*(reg *)0x40007420u) /* both: channel 2 in the upper half */
#define DAC_CR_EN1 (1u << 0)
#define DAC_CR_EN2 (1u << 16)
#define DAC_CR_UNBUFFERED ((1u << 1) | (1u << 17))

/* SPI2 */
typedef struct {
    reg CR1, CR2, SR, DR;
} spi_registers;
#define SPI2 ((spi_registers *)0x40003800u)
#define SPI_CR1_CPOL (1u << 1)
#define SPI_CR1_MSTR (1u << 2)
#define SPI_CR1_CLOCK_BY_4 (1u << 3)
#define SPI_CR1_SPE (1u << 6)
#define SPI_CR1_SSI (1u << 8)
#define SPI_CR1_SSM (1u << 9)
#define SPI_SR_TXE (1u << 1)
#define SPI_SR_BSY (1u << 7)

/* USART2 */
typedef struct {
    reg SR, DR, BRR, CR1, CR2, CR3;
} usart_registers;
#define USART1 ((usart_registers *)0x40011000u)
#define USART2 ((usart_registers *)0x40004400u)
#define USART_SR_ORE (1u << 3)
#define USART_SR_RXNE (1u << 5)
#define USART_SR_TXE (1u << 7)
#define USART_CR1_RE (1u << 2)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_RXNEIE (1u << 5)
#define USART_CR1_UE (1u << 13)

/* Independent watchdog */
#define IWDG_KR (*(reg *)0x40003000u)
#define IWDG_PR (*(reg *)0x40003004u)
#define IWDG_RLR (*(reg *)0x40003008u)
#define IWDG_KR_SERVICE 0xAAAAu
#define IWDG_KR_UNLOCK 0x5555u
#define IWDG_KR_START 0xCCCCu
#define IWDG_PR_BY_4 0u

/* External interrupts; line 16 is the supply monitor */
#define EXTI_IMR (*(reg *)0x40013C00u)
#define EXTI_RTSR (*(reg *)0x40013C08u)
#define EXTI_LINE_SUPPLY (1u << 16)

/* The processor */
typedef struct {
    reg CSR, RVR, CVR;
} systick_registers;
#define SYSTICK ((systick_registers *)0xE000E010u)
#define SYSTICK_CSR_ON_WITH_INTERRUPT 7u /* counts the processor's clock */
#define SCB_CPACR (*(reg *)0xE000ED88u)
#define SCB_CPACR_FPU (0xFu << 20)
#define NVIC_ISER ((reg *)0xE000E100u)
#define NVIC_ICER ((reg *)0xE000E180u)
#define NVIC_IPR ((volatile uint8_t *)0xE000E400u)

enum { IRQ_SUPPLY = 1, IRQ_TIM2 = 28, IRQ_USART2 = 38, IRQ_COUNT = 97 };

#endif
