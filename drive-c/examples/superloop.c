/* A drive in a plain superloop: a tick, its inputs, the model, its outputs.
 *
 * It runs on a desktop; what a board has in the place of a function is said beside it. */
#include <stdint.h>
#include <stdio.h>

#include "drive.h"

#define ONE_Q28 (268435456)

/* On a board: waits for the flag of a timer that elapses every DRIVE_TICK_S. */
static uint32_t wait_for_tick(uint32_t tick)
{
    return tick + 1U;
}

/* On a board: the command that the valve is given. Here: 3 V for the first half of a second, then 0 V. */
static int32_t command_q28(uint32_t tick)
{
    const double volts = ((double)tick * DRIVE_TICK_S < 0.5) ? 3.0 : 0.0;
    return (int32_t)((volts / DRIVE_COMMAND_BASE_V * ONE_Q28) + 0.5);
}

/* On a board: an output, a display, a bus. */
static void put_out(uint32_t tick, const drive_reading_t *reading)
{
    const double position_mm = ((double)reading->position_q56 / 72057594037927936.0) * DRIVE_POSITION_BASE_M * 1e3;
    const double pressure_a_bar = ((double)reading->pressure_a_q28 / ONE_Q28) * DRIVE_PRESSURE_BASE_PA / 1e5;
    (void)printf("%4.0f ms  %7.3f mm  A %5.1f bar\n", (double)tick * DRIVE_TICK_S * 1e3, position_mm, pressure_a_bar);
}

int main(void)
{
    static drive_state_t state;
    const drive_rest_t rest = {
        .position_q56 = INT64_C(36028797018963968), /* the middle of the stroke */
        .command_q28 = 0,
        .pressure_a_q28 = (3 * ONE_Q28) / 10, /* of the supply */
        .pressure_b_q28 = ONE_Q28 / 2,
    };
    uint32_t tick = 0U;

    if (drive_fingerprint() != DRIVE_FINGERPRINT)
    {
        (void)puts("the library is that of another drive than the header");
        return 1;
    }
    drive_init(&state, &rest);
    while (tick < 1000U) /* on a board: for ever */
    {
        drive_input_t input = { 0 };
        drive_reading_t reading;

        input.command_q28 = command_q28(tick);
        drive_step(&state, &input);
        drive_read(&state, &reading);
        tick = wait_for_tick(tick);
        if ((tick % 250U) == 0U)
        {
            put_out(tick, &reading);
        }
    }
    return 0;
}
