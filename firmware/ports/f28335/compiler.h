/* What TI's compiler for the C28x has beside C, and its stand-in on a host. Never compiled by
 * TI's compiler.
 *
 * On a host the registers are the test's: reads and writes, and what the processor does by an
 * instruction of its own, go through pointers that a test sets. */
#ifndef HB_COMPILER_H
#define HB_COMPILER_H

#include "types.h"

#ifdef __TMS320C28XX__

#define HB_INTERRUPT __interrupt
typedef HB_INTERRUPT void (*hb_handler)(void);

extern __cregister volatile unsigned int IER; /* which groups of interrupts get through */
extern __cregister volatile unsigned int IFR;
#define HB_IER IER
#define HB_IFR IFR

#define HB_ENABLE_INTERRUPTS() __asm(" CLRC INTM")
#define HB_DISABLE_INTERRUPTS() __asm(" SETC INTM")
#define HB_ALLOW() __asm(" EALLOW") /* writes to protected registers ... */
#define HB_PROTECT() __asm(" EDIS") /* ... and no more */
#define HB_FLOAT_FLAGS() __asm(" SETFLG RNDF32=1") /* round to nearest, as the host does */
/* The factory's routine in reserved memory, which sets the ADC's trim. */
#define HB_CALIBRATE_ADC() ((void (*)(void))0x380080UL)()
#define HB_HANG() \
    for (;;) {    \
    }

/* All of the port's registers lie in the first 64K words. */
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
