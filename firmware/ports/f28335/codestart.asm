; Target of the boot ROM's jump: a branch of two words. Turns off the watchdog, which the ROM leaves
; running, before TI's startup; hb_board_start turns it on again.
; Never assembled by TI's assembler, never run.

        .ref    _c_int00
        .global hb_codestart

        .sect   "codestart"
hb_codestart:
        LB      watchdog_off

        .sect   "startup"
watchdog_off:
        SETC    OBJMODE                 ; C28x instructions from here on
        CLRC    AMODE
        EALLOW
        MOVL    XAR4, #0x7029           ; WDCR
        MOV     *+XAR4[0], #0x0068
        EDIS
        LB      _c_int00
