/* Addresses and bits of the F28335's registers that this port uses. Never compiled by TI's
 * compiler.
 *
 * Sources: C2000Ware's headers for the F2833x (BSD) and SPRUI07. Values marked "check" are from
 * memory; verify them first. */
#ifndef HB_REGISTERS_H
#define HB_REGISTERS_H

/* CPU timer 0 */
#define HB_TIM 0x0C00u  /* low word of a counter that counts down */
#define HB_PRD 0x0C02u
#define HB_PRDH 0x0C03u
#define HB_TCR 0x0C04u
#define HB_TPR 0x0C06u  /* counts each (TPR + 1)th cycle */
#define HB_TPRH 0x0C07u
#define HB_TCR_STOP 0x0010u
#define HB_TCR_RELOAD 0x0020u

/* Interrupts: group n of the PIE has its enables and flags at 2(n - 1) words from group 1's. */
#define HB_PIECTRL 0x0CE0u
#define HB_PIEACK 0x0CE1u
#define HB_PIEIER1 0x0CE2u
#define HB_PIEIER9 0x0CF2u
#define HB_PIE_GROUPS 12u
#define HB_PIE_VECTORS 0x0D00u /* protected; 128 of two words */
#define HB_VECTORS 128u
#define HB_VECTOR_ADC 37u      /* INT1.6 */
#define HB_VECTOR_SCI_RX 96u   /* INT9.1, SCI-A */
#define HB_PIEIER1_ADC 0x0020u
#define HB_PIEIER9_SCI_RX 0x0001u
#define HB_INT1 0x0001u /* bits of IER and PIEACK */
#define HB_INT9 0x0100u

/* McBSP-A */
#define HB_DXR2 0x5002u
#define HB_DXR1 0x5003u
#define HB_SPCR2 0x5004u
#define HB_SPCR1 0x5005u
#define HB_RCR2 0x5006u
#define HB_RCR1 0x5007u
#define HB_XCR2 0x5008u
#define HB_XCR1 0x5009u
#define HB_SRGR2 0x500Au
#define HB_SRGR1 0x500Bu
#define HB_MCR2 0x500Cu
#define HB_MCR1 0x500Du
#define HB_PCR 0x5012u
#define HB_MFFINT 0x5023u
#define HB_SPCR2_XRST 0x0001u
#define HB_SPCR2_XRDY 0x0002u
#define HB_SPCR2_GRST 0x0040u
#define HB_SPCR2_FRST 0x0080u
#define HB_SPCR1_RRST 0x0001u
#define HB_SPCR1_CLKSTP 0x1000u /* clock stop mode 2: SPI without delay */
#define HB_WORDS_OF_24_BITS 0x0080u
#define HB_DELAY_1_BIT 0x0001u
#define HB_PCR_SPI_MASTER 0x0F08u  /* makes clock and frame, frame active low, clock idle low */
#define HB_SRGR2_LSPCLK 0x2000u

/* ePWM1 */
#define HB_TBCTL 0x6800u
#define HB_TBPHS 0x6803u
#define HB_TBCTR 0x6804u
#define HB_TBPRD 0x6805u
#define HB_ETSEL 0x6819u
#define HB_ETPS 0x681Au
#define HB_ETFLG 0x681Bu
#define HB_ETCLR 0x681Cu
#define HB_TBCTL_UP 0x0030u  /* counts up, undivided, no sync pulse */
#define HB_ETSEL_SOCA_AT_PERIOD 0x0A00u
#define HB_ETPS_SOCA_EACH 0x0100u
#define HB_ET_SOCA 0x0004u

/* GPIO, control registers protected; the high word of a pair holds pins 24..31 or 16..31 */
#define HB_GPAQSEL2 0x6F84u
#define HB_GPAMUX1 0x6F86u
#define HB_GPAMUX2 0x6F88u
#define HB_GPADIR 0x6F8Au
#define HB_GPASET 0x6FC2u
#define HB_GPACLEAR 0x6FC4u

/* System control, all protected */
#define HB_PLLSTS 0x7011u
#define HB_HISPCP 0x701Au
#define HB_LOSPCP 0x701Bu
#define HB_PCLKCR0 0x701Cu
#define HB_PCLKCR1 0x701Du
#define HB_PCLKCR3 0x7020u
#define HB_PLLCR 0x7021u
#define HB_SCSR 0x7022u
#define HB_WDKEY 0x7025u
#define HB_WDCR 0x7029u
#define HB_PLLSTS_LOCKED 0x0001u
#define HB_PLLSTS_NO_CLOCK 0x0008u  /* the oscillator is missing */
#define HB_PLLSTS_NO_WATCH 0x0040u  /* don't look for a missing oscillator */
#define HB_PLLSTS_DIVSEL 0x0180u
#define HB_PLLSTS_HALF 0x0100u
#define HB_PCLKCR0_TBCLKSYNC 0x0004u
#define HB_PCLKCR0_ADC 0x0008u
#define HB_PCLKCR0_SCIA 0x0400u
#define HB_PCLKCR0_MCBSPA 0x1000u
#define HB_PCLKCR1_EPWM1 0x0001u
#define HB_PCLKCR3_TIMER0 0x0100u
#define HB_PCLKCR3_GPIO_IN 0x2000u
#define HB_WDCR_OFF 0x0068u
#define HB_WDCR_ON 0x002Au /* OSCCLK / 512 / 2, 256 counts: 8.7 ms (check) */

/* SCI-A */
#define HB_SCICCR 0x7050u
#define HB_SCICTL1 0x7051u
#define HB_SCIHBAUD 0x7052u
#define HB_SCILBAUD 0x7053u
#define HB_SCICTL2 0x7054u
#define HB_SCIRXST 0x7055u
#define HB_SCIRXBUF 0x7057u
#define HB_SCITXBUF 0x7059u
#define HB_SCIFFTX 0x705Au
#define HB_SCIFFRX 0x705Bu
#define HB_SCIFFCT 0x705Cu
#define HB_SCICCR_8N1 0x0007u
#define HB_SCICTL1_RESET 0x0003u /* receiver and transmitter on, held in reset */
#define HB_SCICTL1_RUN 0x0023u
#define HB_SCICTL2_RX_INTERRUPT 0x0002u
#define HB_SCIRXST_ERROR 0x0080u
#define HB_SCIFFTX_ON 0xE040u
#define HB_SCIFFRX_ON 0x2021u    /* interrupt from one octet on */
#define HB_SCIFFRX_SEEN 0x0040u  /* clears the interrupt's flag */
#define HB_SCIFFRX_CLEAR_OVERFLOW 0x4000u
#define HB_SCIFFRX_OVERFLOW 0x8000u
#define HB_SCI_FIFO_OCTETS 16u /* check */

/* ADC */
#define HB_ADCRESULT 0x0B00u /* the mirror: 16 results, right-justified (check) */
#define HB_ADCTRL1 0x7100u
#define HB_ADCTRL2 0x7101u
#define HB_ADCMAXCONV 0x7102u
#define HB_ADCCHSELSEQ1 0x7103u
#define HB_ADCTRL3 0x7118u
#define HB_ADCST 0x7119u
#define HB_ADCTRL1_RESET 0x4000u
#define HB_ADCTRL1_CASCADED 0x0010u
#define HB_ADCTRL1_ACQ_PS 8u  /* lowest bit of the window: ACQ_PS + 1 clocks */
#define HB_ADCTRL2_EPWM_SOCA 0x0100u
#define HB_ADCTRL2_INTERRUPT 0x0800u
#define HB_ADCTRL2_START 0x2000u
#define HB_ADCTRL2_RESET_SEQ1 0x4000u
#define HB_ADCTRL3_POWER 0x00E0u
#define HB_ADCST_INT_SEQ1 0x0001u
#define HB_ADCST_CLEAR_SEQ1 0x0010u

#endif
