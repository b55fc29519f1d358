/* A drive as a function block of a PLC's C runtime (IEC 61131-3): the runtime calls the block's body once in each cycle of its task with a pointer to the
 * block's variables. REAL is float, and a cycle is a whole number of the drive's ticks.
 *
 * The block's part ends at main, which stands for the runtime. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "drive.h"

/* Variables of the block, as the runtime lays them out. */
typedef struct {
    /* VAR_INPUT */
    bool enable;
    float command_v;
    float load_n;
    float cycle_s; /* of the task */
    /* VAR_OUTPUT */
    bool valid;
    float position_mm;
    float velocity_mm_per_s;
    float pressure_a_bar;
    float pressure_b_bar;
    /* VAR */
    bool was_enabled;
    drive_state_t state;
} drive_model_t;

/* A value over its base as a word, held within the range of +-8. */
static int32_t word_of(float value, double base)
{
    const double words = ((double)value / base) * 268435456.0;
    int32_t word = 0; /* of a value that is no number */

    if (words >= 2147483647.0)
    {
        word = INT32_MAX;
    }
    else if (words <= -2147483648.0)
    {
        word = INT32_MIN;
    }
    else if (words == words)
    {
        word = (int32_t)words;
    }
    return word;
}

static float value_of(int32_t word, double base)
{
    return (float)(((double)word / 268435456.0) * base);
}

/* One cycle of the block. */
void drive_model_body(drive_model_t *block);

void drive_model_body(drive_model_t *block)
{
    const double ticks = ((double)block->cycle_s / DRIVE_TICK_S) + 0.5;
    const uint32_t whole = ((ticks >= 1.0) && (ticks < 1000.0)) ? (uint32_t)ticks : 0U;
    /* A cycle is a whole number of ticks, to a hundredth of one. */
    const double rest_of_tick = ticks - 0.5 - (double)whole;
    const bool fits = (whole > 0U) && (rest_of_tick > -0.01) && (rest_of_tick < 0.01);

    block->valid = block->enable && fits && (drive_fingerprint() == DRIVE_FINGERPRINT);
    if (block->valid && !block->was_enabled)
    {
        /* At rest in the middle of its stroke, both pressures half of the supply. */
        const drive_rest_t rest = { INT64_C(36028797018963968), 0, 134217728, 134217728 };
        drive_init(&block->state, &rest);
    }
    block->was_enabled = block->valid;
    if (block->valid)
    {
        drive_input_t input = { 0 };
        drive_reading_t reading;
        uint32_t tick;

        input.command_q28 = word_of(block->command_v, DRIVE_COMMAND_BASE_V);
        input.load_q28 = word_of(block->load_n, DRIVE_FORCE_BASE_N);
        for (tick = 0U; tick < whole; tick++)
        {
            drive_step(&block->state, &input);
        }
        drive_read(&block->state, &reading);
        block->position_mm = (float)(((double)reading.position_q56 / 72057594037927936.0) * DRIVE_POSITION_BASE_M * 1e3);
        block->velocity_mm_per_s = value_of(reading.velocity_q28, DRIVE_VELOCITY_BASE_M_PER_S * 1e3);
        block->pressure_a_bar = value_of(reading.pressure_a_q28, DRIVE_PRESSURE_BASE_PA / 1e5);
        block->pressure_b_bar = value_of(reading.pressure_b_q28, DRIVE_PRESSURE_BASE_PA / 1e5);
    }
}

/* The runtime: a task of 4 ms that gives 3 V for half a second. */
int main(void)
{
    static drive_model_t block;
    uint32_t cycle;

    block.enable = true;
    block.cycle_s = 0.004F;
    for (cycle = 1U; cycle <= 250U; cycle++)
    {
        block.command_v = (cycle <= 125U) ? 3.0F : 0.0F;
        drive_model_body(&block);
        if ((cycle % 50U) == 0U)
        {
            (void)printf("%4u ms  %7.3f mm  A %5.1f bar\n", (unsigned int)(4U * cycle), (double)block.position_mm, (double)block.pressure_a_bar);
        }
    }
    return block.valid ? 0 : 1;
}
