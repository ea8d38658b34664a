/* clock.h for QEMU's machine netduinoplus2, in place of clock.c. QEMU models neither the clocks'
 * readiness, nor the DMA, nor the inputs of the ADC. This file
 *   - leaves the clocks alone, and states the rate of QEMU's timers;
 *   - acts as the DMA: before each control interrupt it writes the conversions of a row of words
 *     that the emulator has loaded at ROWS. The rows advance from the first octet on that arrives at
 *     USART1, and stay at the last one;
 *   - corrects timer 2 after a reset: QEMU adds the time of the reset to each of its periods;
 *   - reports each control interrupt to a trace of the emulator, by writes to registers of the EXTI
 *     that this port does not use.
 *
 * The linker puts the functions __wrap_... in front of those of the other files. */
#include "adc.h"
#include "board.h"
#include "clock.h"
#include "dac.h"
#include "registers.h"

#define ROWS ((const volatile uint32_t *)0x08080000u) /* their number, then the words */
#define MIDDLE (ADC_FULL_SCALE / 2u)                  /* of all inputs without rows */

#define EXTI_EMR (*(reg *)0x40013C04u)
#define EXTI_FTSR (*(reg *)0x40013C0Cu)
#define EXTI_SWIER (*(reg *)0x40013C10u)
#define REPORT_BEGIN EXTI_FTSR /* time [ns] at which the control interrupt begins */
#define REPORT_CODES EXTI_EMR  /* T, L1: 12 bits each; highest bit: the row advances now */
#define REPORT_END EXTI_SWIER  /* L2: 12 bits; duration [ns]: 20 bits */
#define ADVANCES (1u << 31)

#define IRQ_TIM4 30
#define TIM4 ((timer_registers *)0x40000800u)
#define NVIC_ICPR ((reg *)0xE000E280u)
#define NEGLIGIBLE_NS 1000u

const char clock_board[] = "stm32f4-emulated";
const uint32_t clock_timer_hz = 1000000000u;

static uint32_t row;
static uint32_t code[HB_VALVES];

void __real_board_control_interrupt(void);
void __wrap_board_control_interrupt(void);
bool __real_dac_write(const hb_i16 codes[HB_VALVES]);
bool __wrap_dac_write(const hb_i16 codes[HB_VALVES]);

static void convert(hb_u16 input, uint32_t word)
{
    volatile uint16_t *conversion =
        &adc_conversions[1][input / ADC_INPUTS][input % ADC_INPUTS];

    /* The mean, of which the first few are one more: their sum is the word. */
    for (uint32_t scan = 0; scan < TIMER_SCANS; scan++) {
        conversion[scan * ADC_INPUTS] =
            (uint16_t)(word / TIMER_SCANS + (scan < word % TIMER_SCANS ? 1u : 0u));
    }
}

bool __wrap_dac_write(const hb_i16 codes[HB_VALVES])
{
    for (uint32_t i = 0; i < HB_VALVES; i++) {
        code[i] = (uint32_t)codes[i] & 0xFFFu;
    }
    return __real_dac_write(codes);
}

void __wrap_board_control_interrupt(void)
{
    const volatile uint16_t *words = (const volatile uint16_t *)&ROWS[1];
    const bool advances = (USART1->SR & USART_SR_RXNE) != 0u && row + 1u < ROWS[0];

    for (hb_u16 i = 0; i < HB_INPUTS; i++) {
        convert(i, ROWS[0] > 0u ? words[HB_INPUTS * row + i] : MIDDLE);
    }
    const uint32_t begin = timer_now();
    REPORT_BEGIN = begin;
    __real_board_control_interrupt();
    const uint32_t duration = timer_now() - begin;
    REPORT_CODES = (advances ? ADVANCES : 0u) | code[HB_VALVE_L1] << 12 | code[HB_VALVE_T];
    REPORT_END = duration << 12 | code[HB_VALVE_L2];
    row += advances ? 1u : 0u;
}

void clock_enable_peripherals(void)
{
}

/* A period of a timer takes its reload value and the time at which its counter was 0. Measured on
 * timer 4, which began in the same reset as timer 2; setting the counter to the time since power-up
 * corrects the latter. */
static void correct_timer_2(void)
{
    __asm__ volatile("cpsid i" ::: "memory"); /* a pending interrupt ends wfi all the same */
    NVIC_ISER[0] = 1u << IRQ_TIM4;
    TIM4->DIER = TIM_DIER_UIE;
    TIM4->CR1 = TIM_CR1_CEN;
    const uint32_t begin = TIM4->CNT;
    TIM4->ARR = 1u;
    while ((TIM4->SR & TIM_SR_UIF) == 0u) {
        __asm__ volatile("wfi");
    }
    const uint32_t reset_ns = TIM4->CNT - begin;
    TIM4->CR1 = 0u;
    NVIC_ICER[0] = 1u << IRQ_TIM4;
    NVIC_ICPR[0] = 1u << IRQ_TIM4;
    __asm__ volatile("cpsie i" ::: "memory");
    if (reset_ns > NEGLIGIBLE_NS) {
        TIM2->CNT = TIM4->CNT + reset_ns;
    }
}

bool clock_start(void)
{
    correct_timer_2();
    USART1->CR1 = USART_CR1_UE | USART_CR1_RE;
    return true;
}
