/* Never compiled by TI's compiler, never run on hardware. */
#include "interrupts.h"

#include "registers.h"

void hb_interrupts_start(hb_handler control, hb_handler receive, hb_handler otherwise)
{
    HB_DISABLE_INTERRUPTS();
    hb_write(HB_PIECTRL, 0u);
    for (hb_u16 group = 0; group < HB_PIE_GROUPS; group++) {
        hb_write((hb_u16)(HB_PIEIER1 + 2u * group), 0u);
        hb_write((hb_u16)(HB_PIEIER1 + 2u * group + 1u), 0u); /* the flags */
    }
    HB_IER = 0u;
    HB_IFR = 0u;

    HB_ALLOW();
    for (hb_u16 vector = 0; vector < HB_VECTORS; vector++) {
        hb_write_vector((hb_u16)(HB_PIE_VECTORS + 2u * vector),
                        vector == HB_VECTOR_ADC      ? control
                        : vector == HB_VECTOR_SCI_RX ? receive
                                                     : otherwise);
    }
    HB_PROTECT();
    hb_write(HB_PIECTRL, 1u);
    hb_write(HB_PIEACK, 0xFFFFu);
    hb_write(HB_PIEIER1, HB_PIEIER1_ADC);
    hb_write(HB_PIEIER9, HB_PIEIER9_SCI_RX);
    HB_IER = HB_INT1 | HB_INT9;
}

void hb_control_handled(void)
{
    hb_write(HB_PIEACK, HB_INT1);
}

void hb_receive_handled(void)
{
    hb_write(HB_PIEACK, HB_INT9);
}

/* In the processor's IER, because changing an enable of the PIE requires a sequence of flags. One
 * instruction each. The receive interrupt saves and restores IER and cannot undo it. */
void hb_mask_control(void)
{
    HB_IER &= (hb_u16)~HB_INT1;
}

void hb_unmask_control(void)
{
    HB_IER |= HB_INT1;
}
