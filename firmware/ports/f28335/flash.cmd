/* The firmware in flash. main.c and TI's library run from flash; all else is copied to RAM and runs
 * there, with the timing of the RAM image. The flash keeps its wait states after reset.
 * Never linked by TI's linker.
 *
 * Memory of an F28335: RAM as in ram.cmd; flash 0x300000-0x33FFFF in eight sectors H to A of 32K
 * words. The last 0x80 words of A are reserved: 0x33FF80 zeros if the passwords are used,
 * 0x33FFF6 the entry from the boot ROM, 0x33FFF8 the passwords, which this file leaves
 * erased (all ones: unlocked). */
-e hb_codestart
-stack 0x400

MEMORY
{
PAGE 0:
    PROGRAM : origin = 0x008000, length = 0x002800  /* L0, L1, half of L2 */
    FLASH_A : origin = 0x338000, length = 0x007F80
    BEGIN   : origin = 0x33FFF6, length = 0x000002
PAGE 1:
    KEPT    : origin = 0x000050, length = 0x0003B0  /* M0 */
    STACK   : origin = 0x000400, length = 0x000400  /* M1 */
    DATA    : origin = 0x00A800, length = 0x001800  /* half of L2, L3 */
    LOG     : origin = 0x00C000, length = 0x004000  /* L4 to L7 */
    FLASH_B : origin = 0x330000, length = 0x008000
}

SECTIONS
{
    codestart : > BEGIN,   PAGE = 0
    startup   : > FLASH_A, PAGE = 0

    program :
    {
        commands.obj(.text) control.obj(.text) core.obj(.text) crc.obj(.text) filters.obj(.text)
        link.obj(.text) log.obj(.text) octets.obj(.text) payloads.obj(.text) pi.obj(.text)
        safety.obj(.text) schedule.obj(.text) sensors.obj(.text) settings.obj(.text)
        settle.obj(.text) steps.obj(.text) vent.obj(.text) wire.obj(.text)
        adc.obj(.text) board.obj(.text) boots.obj(.text) dac.obj(.text) interrupts.obj(.text)
        system.obj(.text) uart.obj(.text)
    } LOAD = FLASH_A, RUN = PROGRAM,
      LOAD_START(_hb_load_start), RUN_START(_hb_run_start), LOAD_SIZE(_hb_load_size), PAGE = 0

    .text     : > FLASH_A, PAGE = 0                 /* main.obj and the library */
    .cinit    : > FLASH_A, PAGE = 0
    .pinit    : > FLASH_A, PAGE = 0
    .switch   : > FLASH_A, PAGE = 0
    .econst   : > FLASH_B, PAGE = 1
    .reset    : > FLASH_A, PAGE = 0, TYPE = DSECT   /* the ROM's is used */

    hb_kept   : > KEPT,    PAGE = 1                 /* startup must not clear it */
    .stack    : > STACK,   PAGE = 1
    .ebss     : > DATA,    PAGE = 1
    .esysmem  : > DATA,    PAGE = 1
    hb_log    : > LOG,     PAGE = 1
}
