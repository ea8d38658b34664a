#include "log.h"

#include "filters.h"
#include "numeric.h"

#define LAST_START 0x80000000UL /* highest number at which a schedule may start */

static void clear_sums(hb_log *log)
{
    log->ticks = 0;
    for (hb_u16 i = 0; i < HB_INPUTS; i++) {
        log->word_sum[i] = 0;
    }
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        log->u_sum[i] = 0.0f;
    }
    log->v_sum = 0.0f;
    log->any_flags = 0;
    log->all_flags = 0xFFFFu;
}

static hb_u16 signed_word(float value)
{
    return (hb_u16)hb_round_i16(value, -32767, 32767);
}

static void publish(hb_log *log)
{
    hb_u16 *slot = log->ring[log->next & (log->records - 1u)];

    for (hb_u16 i = 0; i < HB_RECORD_WORDS; i++) {
        slot[i] = log->newest[i];
    }
    log->next++;
    log->withheld = false;
}

static void make_record(hb_log *log, float v_ref_m_s)
{
    const float share = 1.0f / (float)log->divider;
    hb_u16 *word = log->newest;

    word[HB_WORD_RUN] = log->run;
    word[HB_WORD_INDEX] = log->index++;
    word[HB_WORD_FLAGS] =
        (hb_u16)((log->all_flags & HB_FLAG_AT_REFERENCE)
                 | (log->any_flags & (HB_FLAG_SENSOR_SATURATED | HB_FLAG_VALVE_SATURATED)));
    for (hb_u16 i = 0; i < HB_INPUTS; i++) {
        word[HB_WORD_X + i] = hb_mean_word(log->word_sum[i], log->divider);
    }
    word[HB_WORD_V] = signed_word(log->v_sum * share * HB_WORD_V_PER_SI);
    word[HB_WORD_U_T] = signed_word(log->u_sum[HB_VALVE_T] * share * HB_WORD_U_T_PER_SI);
    word[HB_WORD_U_L1] = signed_word(log->u_sum[HB_VALVE_L1] * share * HB_WORD_U_L1_PER_SI);
    word[HB_WORD_U_L2] = signed_word(log->u_sum[HB_VALVE_L2] * share * HB_WORD_U_L2_PER_SI);
    word[HB_WORD_V_REF] = signed_word(v_ref_m_s * HB_WORD_V_REF_PER_SI);
    log->withheld = true;
}

void hb_log_init(hb_log *log, hb_log_record *ring, hb_u16 records)
{
    log->ring = ring;
    log->records = records;
    log->next = 0;
    hb_log_begin(log, 0, 1);
}

void hb_log_begin(hb_log *log, hb_u16 run, hb_u16 divider)
{
    log->run = run;
    log->divider = divider;
    log->index = 0;
    log->withheld = false;
    clear_sums(log);
}

void hb_log_add(hb_log *log, const hb_sample *sample)
{
    for (hb_u16 i = 0; i < HB_INPUTS; i++) {
        log->word_sum[i] += sample->adc[i];
    }
    for (hb_u16 i = 0; i < HB_VALVES; i++) {
        log->u_sum[i] += sample->u[i];
    }
    log->v_sum += sample->v_m_s;
    log->any_flags = (hb_u16)(log->any_flags | sample->flags);
    log->all_flags = (hb_u16)(log->all_flags & sample->flags);
    log->ticks++;

    if (log->ticks == log->divider) {
        if (log->withheld) {
            publish(log);
        }
        make_record(log, sample->v_ref_m_s);
        clear_sums(log);
    }
}

void hb_log_end(hb_log *log, hb_u16 flags)
{
    if (log->withheld) {
        log->newest[HB_WORD_FLAGS] = (hb_u16)(log->newest[HB_WORD_FLAGS] | flags);
        publish(log);
    }
}

bool hb_log_has_numbers(const hb_log *log)
{
    return log->next <= LAST_START;
}

hb_u32 hb_log_first(const hb_log *log)
{
    return log->next > log->records ? log->next - log->records : 0u;
}

const hb_u16 *hb_log_words(const hb_log *log, hb_u32 number)
{
    return log->ring[number & (log->records - 1u)];
}
