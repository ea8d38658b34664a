/* Never run on hardware. */
#include "uart.h"

#include "clock.h"
#include "pins.h"

#define DIVIDER ((CLOCK_APB1_HZ + HB_BAUD / 2u) / HB_BAUD)
#define ACTUAL (CLOCK_APB1_HZ / DIVIDER)
#define OFF (ACTUAL > HB_BAUD ? ACTUAL - HB_BAUD : HB_BAUD - ACTUAL)
HB_ASSERT(the_divider_fits, DIVIDER >= 16u && DIVIDER <= 65535u);
HB_ASSERT(the_rate_is_within_2_percent, 50u * OFF <= HB_BAUD);

#define FUNCTION_USART2 7u
#define TX_PIN 2u
#define RX_PIN 3u

/* A host has several requests of 13 or more octets in flight while a reply is sent. */
#define QUEUE_OCTETS 256u /* a power of two, because the counters wrap */

static volatile uint8_t queue[QUEUE_OCTETS];
static volatile uint32_t written; /* by the interrupt */
static volatile uint32_t taken;   /* by the idle loop */
static bool sending;

void uart_start(void)
{
    pin_pull_up(GPIOA, RX_PIN); /* quiet without a host */
    pin_set_alternate(GPIOA, TX_PIN, FUNCTION_USART2);
    pin_set_alternate(GPIOA, RX_PIN, FUNCTION_USART2);
    USART2->BRR = DIVIDER;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    NVIC_ISER[IRQ_USART2 / 32] = 1u << (IRQ_USART2 % 32);
}

void uart_receive_interrupt(void)
{
    /* Reading the state and then the data also clears an overrun; the host repeats what was lost. */
    while ((USART2->SR & (USART_SR_RXNE | USART_SR_ORE)) != 0u) {
        const uint8_t octet = (uint8_t)USART2->DR;
        if (written - taken < QUEUE_OCTETS) {
            queue[written % QUEUE_OCTETS] = octet;
            written++;
        }
    }
}

bool uart_read(void *context, hb_octet *octet)
{
    (void)context;
    if (written == taken) {
        return false;
    }
    *octet = queue[taken % QUEUE_OCTETS];
    taken++;
    return true;
}

hb_u16 uart_write(void *context, const hb_octet *octets, hb_u16 count)
{
    hb_u16 accepted = 0;

    (void)context;
    while (accepted < count && (USART2->SR & USART_SR_TXE) != 0u) {
        USART2->DR = octets[accepted];
        accepted++;
    }
    sending = accepted < count;
    return accepted;
}

bool uart_is_sending(void)
{
    return sending;
}
