/* Runs an image of play.c on simavr's AVR core, with the script from stdin and its output to stdout.
 * The core has 64 KB of RAM, which an AVR can address although no chip has it, so that the whole
 * firmware fits unchanged. */
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_io.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* Addresses of an ATmega1284P. */
enum { GPIOR0 = 0x3E, GPIOR1 = 0x4A, GPIOR2 = 0x4B };

static FILE *output;

static uint8_t give_next(struct avr_t *avr, avr_io_addr_t address, void *param)
{
    const int octet = getchar();

    (void)avr, (void)address, (void)param;
    return octet == EOF ? 0 : (uint8_t)octet;
}

static uint8_t give_more(struct avr_t *avr, avr_io_addr_t address, void *param)
{
    const int octet = getchar();

    (void)avr, (void)address, (void)param;
    ungetc(octet, stdin);
    return octet != EOF;
}

static void take_octet(struct avr_t *avr, avr_io_addr_t address, uint8_t octet, void *param)
{
    (void)avr, (void)address, (void)param;
    fputc(octet, output);
}

static void take_end(struct avr_t *avr, avr_io_addr_t address, uint8_t code, void *param)
{
    (void)avr, (void)address, (void)param;
    exit(code);
}

int main(int argc, char **argv)
{
    elf_firmware_t image = {0};
    avr_t *avr = avr_make_mcu_by_name("atmega1284p");

    /* simavr prints to stdout; redirect it to stderr. */
    output = fdopen(dup(STDOUT_FILENO), "wb");
    dup2(STDERR_FILENO, STDOUT_FILENO);
    if (argc != 2 || output == NULL || avr == NULL || elf_read_firmware(argv[1], &image) != 0) {
        return 2;
    }
    avr->ramend = 0xFFFF;
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr_load_firmware(avr, &image);
    avr_register_io_read(avr, GPIOR0, give_next, NULL);
    avr_register_io_write(avr, GPIOR1, take_octet, NULL);
    avr_register_io_read(avr, GPIOR2, give_more, NULL);
    avr_register_io_write(avr, GPIOR2, take_end, NULL);
    for (;;) {
        const int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) {
            return 3;
        }
    }
}
