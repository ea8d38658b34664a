/* The state of the board: settings and schedule from the host, control, limits and log. The
 * control interrupt advances it (hb_core_tick in hal.h), the requests in commands.h change it. */
#ifndef HB_CORE_H
#define HB_CORE_H

#include "control.h"
#include "hal.h"
#include "log.h"
#include "safety.h"
#include "schedule.h"
#include "sensors.h"
#include "settings.h"
#include "steps.h"

struct hb_core {
    hb_hal hal;

    /* Uploaded by the host. */
    hb_settings settings;
    hb_steps steps;

    /* Derived from the settings whenever they change. */
    hb_sensors_config sensors_config;
    hb_control_config control_config;
    hb_schedule_config schedule_config;
    hb_safety_config safety_config;

    hb_u16 state;
    hb_u16 fault; /* latched in HB_STATE_FAULT; HB_FAULT_STOPPED also remains at rest */
    hb_u32 tick;
    hb_safety_state safety;
    hb_sensors_state sensors;
    hb_control_state control;
    hb_schedule_state schedule;
    hb_log log;

    /* The request that started the schedule, to recognise its repetition, however late. Cleared
     * by the next upload. */
    bool started;
    hb_octet start_sequence;
    hb_u16 start_settings_crc;
    hb_u16 start_steps_crc;
};

/* Derives the configurations from the settings. */
void hb_core_configure(hb_core *core);
/* Begins the schedule. */
void hb_core_start(hb_core *core);
/* Ends the schedule; the valves are neutral from now on. */
void hb_core_halt(hb_core *core, hb_u16 state, hb_u16 fault);
/* Restarts the heartbeat's time: a request that the board knows has come from the host. */
void hb_core_heartbeat(hb_core *core);

#endif
