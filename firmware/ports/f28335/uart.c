/* Never compiled by TI's compiler, never run on hardware. */
#include "uart.h"

#include "compiler.h"
#include "registers.h"
#include "system.h"

#define DIVIDER ((HB_LSPCLK_HZ + 4UL * HB_BAUD) / (8UL * HB_BAUD)) /* rounded */
#define ACTUAL (HB_LSPCLK_HZ / (8UL * DIVIDER))
#define OFF (ACTUAL > HB_BAUD ? ACTUAL - HB_BAUD : HB_BAUD - ACTUAL)
HB_ASSERT(the_divider_fits, DIVIDER >= 2UL && DIVIDER <= 65536UL);
HB_ASSERT(the_rate_is_within_2_percent, 50UL * OFF <= HB_BAUD);

#define MUX_SCI 0x0500u      /* GPIO28 and 29, in the high word */
#define MUX_SCI_MASK 0x0F00u
#define UNSAMPLED_RX 0x0300u /* no input qualification on GPIO28 */

/* A host has several requests of 13 or more octets in flight while a reply is sent. */
#define RING_OCTETS 256u /* a power of two, because the counters wrap */
#define RING_MASK (RING_OCTETS - 1u)

/* The interrupt writes the first two, the idle loop the third; access to a word is atomic. */
static volatile hb_octet ring[RING_OCTETS];
static volatile hb_u16 written;
static volatile hb_u16 taken;

void hb_uart_start(void)
{
    written = 0;
    taken = 0;
    HB_ALLOW();
    hb_write(HB_GPAQSEL2 + 1u, (hb_u16)(hb_read(HB_GPAQSEL2 + 1u) | UNSAMPLED_RX));
    hb_write(HB_GPAMUX2 + 1u, (hb_u16)((hb_read(HB_GPAMUX2 + 1u) & ~MUX_SCI_MASK) | MUX_SCI));
    HB_PROTECT();
    hb_write(HB_SCICTL1, HB_SCICTL1_RESET);
    hb_write(HB_SCICCR, HB_SCICCR_8N1);
    hb_write(HB_SCIHBAUD, (hb_u16)((DIVIDER - 1UL) >> 8));
    hb_write(HB_SCILBAUD, (hb_u16)((DIVIDER - 1UL) & 0xFFUL));
    hb_write(HB_SCICTL2, HB_SCICTL2_RX_INTERRUPT);
    hb_write(HB_SCIFFTX, HB_SCIFFTX_ON);
    hb_write(HB_SCIFFRX, HB_SCIFFRX_ON | HB_SCIFFRX_SEEN | HB_SCIFFRX_CLEAR_OVERFLOW);
    hb_write(HB_SCIFFCT, 0u);
    hb_write(HB_SCICTL1, HB_SCICTL1_RUN);
}

static hb_u16 in_fifo(hb_u16 control)
{
    return (hb_u16)((hb_read(control) >> 8) & 0x1Fu);
}

void hb_uart_receive(void)
{
    while (in_fifo(HB_SCIFFRX) > 0u) {
        do {
            const hb_octet octet = (hb_octet)(hb_read(HB_SCIRXBUF) & 0xFFu);
            if ((hb_u16)(written - taken) < RING_OCTETS) {
                ring[written & RING_MASK] = octet;
                written = (hb_u16)(written + 1u);
            }
        } while (in_fifo(HB_SCIFFRX) > 0u);
        /* An octet that arrives after the check of the outer loop sets the flag again. */
        hb_write(HB_SCIFFRX, HB_SCIFFRX_ON | HB_SCIFFRX_SEEN);
    }
}

bool hb_uart_read(void *context, hb_octet *octet)
{
    (void)context;
    if (written == taken) {
        return false;
    }
    *octet = ring[taken & RING_MASK];
    taken = (hb_u16)(taken + 1u);
    return true;
}

hb_u16 hb_uart_write(void *context, const hb_octet *octets, hb_u16 count)
{
    const hb_u16 room = (hb_u16)(HB_SCI_FIFO_OCTETS - in_fifo(HB_SCIFFTX));
    const hb_u16 accepted = count < room ? count : room;

    (void)context;
    for (hb_u16 i = 0; i < accepted; i++) {
        hb_write(HB_SCITXBUF, (hb_u16)(octets[i] & 0xFFu));
    }
    return accepted;
}

void hb_uart_recover(void)
{
    /* Without HB_SCIFFRX_SEEN, which could lose an interrupt. */
    if ((hb_read(HB_SCIFFRX) & HB_SCIFFRX_OVERFLOW) != 0u) {
        hb_write(HB_SCIFFRX, HB_SCIFFRX_ON | HB_SCIFFRX_CLEAR_OVERFLOW);
    }
    if ((hb_read(HB_SCIRXST) & HB_SCIRXST_ERROR) != 0u) {
        hb_write(HB_SCICTL1, HB_SCICTL1_RESET);
        hb_write(HB_SCICTL1, HB_SCICTL1_RUN);
    }
}
