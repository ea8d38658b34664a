/* Never run on hardware. */
#include "adc.h"

#include "pins.h"

#define UNWRITTEN 0xFFFFu /* no conversion has this value */
#define POWER_UP_US 10u

HB_ASSERT(the_sum_is_the_mean_in_sixteenths, TIMER_SCANS * 4095u == ADC_FULL_SCALE);
HB_ASSERT(the_converters_share_the_inputs, ADC_CONVERTERS * ADC_INPUTS == HB_INPUTS);

/* In the order of the dictionary's inputs: the first four on ADC1, the others on ADC2. */
static const struct {
    gpio_registers *port;
    uint32_t pin;
    uint32_t channel;
} input[HB_INPUTS] = {
    {GPIOA, 0u, 0u},  {GPIOA, 1u, 1u},  {GPIOB, 0u, 8u},  {GPIOC, 1u, 11u},
    {GPIOC, 0u, 10u}, {GPIOC, 2u, 12u}, {GPIOC, 3u, 13u}, {GPIOC, 4u, 14u},
};

volatile uint16_t adc_conversions[2][ADC_CONVERTERS][ADC_CONVERSIONS];

static void start_dma(dma_stream_registers *stream, uint32_t channel, const adc_registers *adc,
                      uint32_t converter)
{
    stream->PAR = (uint32_t)(uintptr_t)&adc->DR;
    stream->M0AR = (uint32_t)(uintptr_t)adc_conversions[0][converter];
    stream->M1AR = (uint32_t)(uintptr_t)adc_conversions[1][converter];
    stream->NDTR = ADC_CONVERSIONS;
    stream->FCR = 0u;
    stream->CR = DMA_CR_CHANNEL(channel) | DMA_CR_DBM | DMA_CR_PRIORITY_HIGH | DMA_CR_MSIZE_16
                 | DMA_CR_PSIZE_16 | DMA_CR_MINC | DMA_CR_CIRC;
    stream->CR |= DMA_CR_EN;
}

static void start_converter(adc_registers *adc, uint32_t first)
{
    uint32_t sequence = 0;

    for (uint32_t i = 0; i < ADC_INPUTS; i++) {
        const uint32_t channel = input[first + i].channel;
        sequence |= channel << (5u * i);
        if (channel < 10u) {
            adc->SMPR2 |= ADC_SMPR_15_CYCLES << (3u * channel);
        } else {
            adc->SMPR1 |= ADC_SMPR_15_CYCLES << (3u * (channel - 10u));
        }
    }
    adc->SQR3 = sequence;
    adc->SQR1 = ADC_SQR1_L(ADC_INPUTS);
    adc->CR1 = ADC_CR1_SCAN;
    adc->CR2 = ADC_CR2_ADON | ADC_CR2_DMA | ADC_CR2_DDS;
    timer_wait(POWER_UP_US);
    adc->CR2 = ADC_CR2_ADON | ADC_CR2_DMA | ADC_CR2_DDS | ADC_CR2_EXTSEL_TIM3_TRGO
               | ADC_CR2_EXTEN_RISING;
}

void adc_start(void)
{
    for (uint32_t i = 0; i < HB_INPUTS; i++) {
        pin_set_mode(input[i].port, input[i].pin, PIN_ANALOG);
    }
    ADC_CCR = ADC_CCR_PCLK2_BY_4; /* 84 MHz / 4 = 21 MHz */
    start_dma(DMA2_STREAM0, 0u, ADC1, 0u);
    start_dma(DMA2_STREAM2, 1u, ADC2, 1u);
    start_converter(ADC1, 0u);
    start_converter(ADC2, ADC_INPUTS);
}

/* Sums a converter's conversions of the last tick. Its last conversion is overwritten by a value
 * that the DMA must replace before the half is read again. */
static bool sum(volatile uint16_t conversions[ADC_CONVERSIONS], hb_u16 words[ADC_INPUTS])
{
    volatile uint16_t *last = &conversions[ADC_CONVERSIONS - 1u];
    const bool complete = *last != UNWRITTEN;

    if (!complete) {
        *last = conversions[ADC_CONVERSIONS - 1u - ADC_INPUTS];
    }
    for (uint32_t i = 0; i < ADC_INPUTS; i++) {
        uint32_t total = 0;
        for (uint32_t scan = 0; scan < TIMER_SCANS; scan++) {
            total += conversions[scan * ADC_INPUTS + i];
        }
        words[i] = (hb_u16)total;
    }
    *last = UNWRITTEN;
    return complete;
}

bool adc_read(hb_u16 words[HB_INPUTS])
{
    const uint32_t half1 = (DMA2_STREAM0->CR & DMA_CR_CT) != 0u ? 0u : 1u;
    const uint32_t half2 = (DMA2_STREAM2->CR & DMA_CR_CT) != 0u ? 0u : 1u;
    const bool first = sum(adc_conversions[half1][0], words);
    const bool second = sum(adc_conversions[half2][1], &words[ADC_INPUTS]);

    return first && second;
}
