/* The firmware's core: one context, allocated by the port, and its calls (see hal.h). */
#ifndef HB_CORE_H
#define HB_CORE_H

#include "config.h"
#include "control.h"
#include "hal.h"
#include "log.h"
#include "safety.h"
#include "schedule.h"
#include "sensors.h"
#include "settings.h"
#include "steps.h"
#include "wire.h"

typedef struct {
    hb_hal hal;
    hb_u16 boots;

    /* What the host sent. */
    hb_settings settings;
    hb_steps steps;

    /* What follows from the settings, worked out when they change. */
    hb_sensors_config sensors_config;
    hb_control_config control_config;
    hb_schedule_config schedule_config;
    hb_safety_config safety_config;

    hb_u16 state;
    hb_u16 fault; /* latched in HB_STATE_FAULT; HB_FAULT_STOPPED also stands at rest */
    hb_u32 tick;
    hb_safety_state safety;
    hb_sensors_state sensors;
    hb_control_state control;
    hb_schedule_state schedule;
    hb_log log;

    /* The request that started the schedule, to know it when it is sent again, however late:
     * until something is uploaded. */
    bool started;
    hb_octet start_sequence;
    hb_u16 start_settings_crc;
    hb_u16 start_steps_crc;

    hb_receiver receiver;
    hb_octet reply[HB_MAX_FRAME];
    hb_octet out[HB_MAX_ON_WIRE];
    hb_u16 out_count;
    hb_u16 out_sent;
} hb_core;

/* boots: a number that differs after each reset. */
void hb_core_init(hb_core *core, const hb_hal *hal, hb_log_ring ring, hb_u16 boots);
void hb_core_tick(hb_core *core, const hb_u16 adc[HB_SENSORS], hb_i16 dac[HB_VALVES]);
void hb_core_poll(hb_core *core);
void hb_core_overrun(hb_core *core);

/* For the commands. */
void hb_core_configure(hb_core *core);
void hb_core_start(hb_core *core);
/* Valves to neutral from now on, the schedule left. */
void hb_core_halt(hb_core *core, hb_u16 state, hb_u16 fault);

#endif
