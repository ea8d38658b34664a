/* Keywords and instructions of TI's compiler for the C28x, and their substitutes on a host. Never
 * compiled by TI's compiler.
 *
 * On a host a test simulates the registers: reads, writes and special instructions call functions
 * through pointers that the test sets. */
#ifndef HB_COMPILER_H
#define HB_COMPILER_H

#include "types.h"

#ifdef __TMS320C28XX__

#define HB_INTERRUPT __interrupt
typedef HB_INTERRUPT void (*hb_handler)(void);

extern __cregister volatile unsigned int IER; /* enabled groups of interrupts */
extern __cregister volatile unsigned int IFR;
#define HB_IER IER
#define HB_IFR IFR

#define HB_ENABLE_INTERRUPTS() __asm(" CLRC INTM")
#define HB_DISABLE_INTERRUPTS() __asm(" SETC INTM")
#define HB_ALLOW() __asm(" EALLOW") /* enable writes to protected registers */
#define HB_PROTECT() __asm(" EDIS") /* disable them */
#define HB_FLOAT_FLAGS() __asm(" SETFLG RNDF32=1") /* round to nearest, as the host does */
/* Routine in reserved memory that sets the ADC's factory trim. */
#define HB_CALIBRATE_ADC() ((void (*)(void))0x380080UL)()
#define HB_HANG() \
    for (;;) {    \
    }

/* All registers of this port are in the first 64K words. */
static inline hb_u16 hb_read(hb_u16 address)
{
    return *(volatile hb_u16 *)(hb_u32)address;
}

static inline void hb_write(hb_u16 address, hb_u16 value)
{
    *(volatile hb_u16 *)(hb_u32)address = value;
}

static inline void hb_write_vector(hb_u16 address, hb_handler handler)
{
    *(volatile hb_u32 *)(hb_u32)address = (hb_u32)handler;
}

#else

#define HB_INTERRUPT
typedef void (*hb_handler)(void);

enum hb_instruction { HB_SETC, HB_CLRC, HB_EALLOW, HB_EDIS, HB_SETFLG, HB_ADC_CAL, HB_FOREVER };

extern hb_u16 (*hb_read)(hb_u16 address);
extern void (*hb_write)(hb_u16 address, hb_u16 value);
extern void (*hb_write_vector)(hb_u16 address, hb_handler handler);
extern void (*hb_execute)(hb_u16 instruction);
extern hb_u16 hb_ier;
extern hb_u16 hb_ifr;

#define HB_IER hb_ier
#define HB_IFR hb_ifr
#define HB_ENABLE_INTERRUPTS() hb_execute(HB_CLRC)
#define HB_DISABLE_INTERRUPTS() hb_execute(HB_SETC)
#define HB_ALLOW() hb_execute(HB_EALLOW)
#define HB_PROTECT() hb_execute(HB_EDIS)
#define HB_FLOAT_FLAGS() hb_execute(HB_SETFLG)
#define HB_CALIBRATE_ADC() hb_execute(HB_ADC_CAL)
#define HB_HANG() hb_execute(HB_FOREVER)

#endif
#endif
