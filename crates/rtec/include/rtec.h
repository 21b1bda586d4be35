/* SPDX-License-Identifier: MIT OR Apache-2.0
 * What a servo thread calls. Structures are those of src/corrector/values.rs; axes are X, Y, Z, lengths mm, times s.
 * Nothing here allocates, blocks, or fails: whoever calls gives the memory, aligned to 64 bytes. */
#ifndef RTEC_H
#define RTEC_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RTEC_AXES 3
#define RTEC_SIGNALS 16

typedef struct {
    double position[RTEC_AXES], tool_offset[RTEC_AXES];
    double signal[RTEC_SIGNALS], age_s[RTEC_SIGNALS];
    double period_s;
    uint32_t heartbeat;
    int32_t line, program, motion_type;
    bool enable, homed, machine_on, probing, touch;
} rtec_inputs;

typedef struct {
    double limit_mm, slew_mm_per_s, resolution_mm;
    double stale_s, freeze_s, leave_s, watchdog_s, off_path_s;
    uint32_t parts;
    bool probe_corrected, pause_program;
} rtec_settings;

typedef struct {
    double correction[RTEC_AXES], model[RTEC_AXES], table[RTEC_AXES], latch[RTEC_AXES];
    double in_use[RTEC_SIGNALS], oldest_age_s;
    int32_t phase, fault, fault_signal, waits_for, signal_fault;
    bool enabled, active, on_path, pause;
} rtec_outputs;

typedef struct rtec_image rtec_image;
typedef struct rtec_state rtec_state;

size_t rtec_image_size(void);
size_t rtec_state_size(void);
/* 0, or the number of a refusal; `bytes` must stay as long as the image does. `serial`: of this machine, may be null: any.
 * `program`, `program_count`: content of the program that shall run, may be null: not compared. */
int32_t rtec_image_init(rtec_image *image, const uint8_t *bytes, size_t count, const char *serial,
                        const uint8_t *program, size_t program_count);
uint32_t rtec_image_signals(const rtec_image *image);
/* Its name and meaning, "hash: ...". Never null. */
const char *rtec_refusal(int32_t number);
const char *rtec_fault(int32_t number);
void rtec_state_init(rtec_state *state);
/* One period: what is to be added to the commands. The state holds directions of travel and readings: it is initialised once, and
 * stays when another image is taken. Signals count as silent until the heartbeat has changed once. */
void rtec_step(rtec_image *image, rtec_state *state, const rtec_inputs *inputs, const rtec_settings *settings,
               rtec_outputs *outputs);
#endif
