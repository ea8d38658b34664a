/* Settings of the bench, uploaded by the host: a float for each setting of the dictionary. */
#ifndef HB_SETTINGS_H
#define HB_SETTINGS_H

#include "dictionary.h"
#include "types.h"

typedef struct {
    float value[HB_SETTINGS];
    bool known[HB_SETTINGS];
} hb_settings;

void hb_settings_init(hb_settings *settings);
void hb_settings_write(hb_settings *settings, hb_u16 index, float value);

/* Every setting has been written. */
bool hb_settings_complete(const hb_settings *settings);
/* Every value is within the range that the control can use. */
bool hb_settings_valid(const hb_settings *settings, float voltage_range_v);
/* CRC-16 of all settings as they are sent, in the order of the dictionary. */
hb_u16 hb_settings_crc(const hb_settings *settings);

#endif
