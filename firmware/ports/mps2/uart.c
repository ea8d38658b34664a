#include "uart.h"

#define UART0_RX_IRQ 0u
#define NVIC_ENABLE (*(volatile uint32_t *)0xE000E100u)

/* Arm Cortex-M System Design Kit, TRM, APB UART. */
typedef struct {
    volatile uint32_t data;
    volatile uint32_t state;
    volatile uint32_t control;
    volatile uint32_t interrupt; /* read: pending; write ones: clear */
    volatile uint32_t baud_divider;
} cmsdk_uart;

#define UART0 ((cmsdk_uart *)0x40004000u)
#define STATE_TX_FULL 1u
#define CONTROL_TX_ON 1u
#define CONTROL_RX_ON 2u
#define CONTROL_RX_INTERRUPT 8u
#define INTERRUPT_RX 2u
#define BAUD_DIVIDER 217u /* 25 MHz / 115200; the emulator requires a value and ignores it */

#define QUEUE_OCTETS 4096u /* a power of two, because the counters wrap */

typedef struct {
    uint8_t octet[QUEUE_OCTETS];
    volatile uint32_t written;
    volatile uint32_t read;
} queue;

static queue from_host;
static queue to_host;
static volatile uint32_t received; /* all octets, including those lost to a full queue */

static bool push(queue *q, uint8_t octet)
{
    const uint32_t written = q->written;

    if (written - q->read == QUEUE_OCTETS) {
        return false;
    }
    q->octet[written % QUEUE_OCTETS] = octet;
    q->written = written + 1u;
    return true;
}

static bool pop(queue *q, uint8_t *octet)
{
    const uint32_t read = q->read;

    if (q->written == read) {
        return false;
    }
    *octet = q->octet[read % QUEUE_OCTETS];
    q->read = read + 1u;
    return true;
}

void uart_init(void)
{
    UART0->baud_divider = BAUD_DIVIDER;
    UART0->control = CONTROL_TX_ON | CONTROL_RX_ON | CONTROL_RX_INTERRUPT;
    NVIC_ENABLE = 1u << UART0_RX_IRQ;
}

void uart_receive_interrupt(void)
{
    UART0->interrupt = INTERRUPT_RX; /* before reading the octet, which admits the next one */
    (void)push(&from_host, (uint8_t)(UART0->data & 0xFFu)); /* lost if the queue is full */
    received++;
}

void uart_await(uint32_t count)
{
    /* A pending interrupt ends wfi even while masked, so none is missed. */
    __asm__ volatile("cpsid i" ::: "memory");
    while (received != count) {
        __asm__ volatile("wfi\n\tcpsie i\n\tisb\n\tcpsid i" ::: "memory");
    }
    __asm__ volatile("cpsie i" ::: "memory");
}

bool uart_take(uint8_t *octet)
{
    return pop(&from_host, octet);
}

bool uart_put(uint8_t octet)
{
    return push(&to_host, octet);
}

void uart_flush(void)
{
    uint8_t octet;

    while (pop(&to_host, &octet)) {
        UART0->data = octet;
        while ((UART0->state & STATE_TX_FULL) != 0u) {
        }
    }
}
