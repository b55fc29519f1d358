/* Steps a baked drive through the inputs of inputs.h and prints what the sensors read after each tick: on a desktop, or freestanding on an emulated Cortex-M
 * by semihosting. */
#include "drive.h"
#include "inputs.h"

#if defined(__ARM_EABI__)
static void semihosting(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static void put(const char *text)
{
    semihosting(0x04U, text);
}

static void leave(int well)
{
    semihosting(0x18U, (const void *)(uintptr_t)(well ? 0x20026U : 0x20023U));
    for (;;)
    {
    }
}
#else
#include <stdio.h>
#include <stdlib.h>

static void put(const char *text)
{
    (void)fputs(text, stdout);
}

static void leave(int well)
{
    exit(well ? 0 : 1);
}
#endif

/* Writes a word in hexadecimal, so that no bit is lost. */
static char *hexadecimal(char *at, uint64_t word, unsigned int digits)
{
    while (digits > 0U)
    {
        digits--;
        *at = "0123456789abcdef"[(word >> (4U * digits)) & 15U];
        at++;
    }
    return at;
}

static void run(void)
{
    static drive_state_t state;
    unsigned int tick;

    drive_init(&state, &rest);
    for (tick = 0U; tick < TICKS; tick++)
    {
        drive_reading_t reading;
        char line[64];
        char *at = line;

        drive_step(&state, &inputs[tick]);
        drive_read(&state, &reading);
        at = hexadecimal(at, (uint64_t)reading.position_q56, 16U);
        at = hexadecimal(at, (uint32_t)reading.velocity_q28, 8U);
        at = hexadecimal(at, (uint32_t)reading.spool_q28, 8U);
        at = hexadecimal(at, (uint32_t)reading.pressure_a_q28, 8U);
        at = hexadecimal(at, (uint32_t)reading.pressure_b_q28, 8U);
        *at = '\n';
        at++;
        *at = '\0';
        put(line);
    }
}

int main(void)
{
    /* A null pointer is harmless. */
    drive_init((drive_state_t *)0, &rest);
    drive_step((drive_state_t *)0, &inputs[0]);
    drive_read((const drive_state_t *)0, (drive_reading_t *)0);
    if (drive_fingerprint() != DRIVE_FINGERPRINT)
    {
        leave(0);
    }
    run();
    leave(1);
    return 0;
}

#if defined(__ARM_EABI__)
extern const uint32_t stack_top[];

void reset(void);

void reset(void)
{
#if defined(__ARM_FP)
    /* Grants access to the floating-point unit. */
    *(volatile uint32_t *)0xE000ED88U |= 0x00F00000U;
#endif
    (void)main();
}

/* What the processor reads at its start. */
typedef struct {
    const uint32_t *stack;
    void (*start)(void);
} vectors_t;

__attribute__((section(".vectors"), used)) static const vectors_t vectors = { stack_top, reset };
#endif
