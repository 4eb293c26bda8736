/* SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-only */
/* Plans handed from a planner to whoever moves the axes: two processes, or a process and a real-time thread.
 *
 * A plan is a run of rows, one a period, that ends at a standstill inside all limits. The reader plays the plan it has
 * until a newer one is there whose rows it can still go over to; if none comes, it plays to the standstill. So a planner
 * that is late, stopped or killed ends in a controlled stop. There is nothing to wait for on the reading side: no lock,
 * no system call, no allocation, and a bounded number of steps in every period.
 *
 * Rows are numbered from the begin of the program on; the number of a row does not change with the plan. A newer plan
 * has the same rows as the one before it up to `branch`, and its own from there on. The reader goes over to it if the
 * next row it needs is not behind `branch`, and else refuses it. At a standstill the reader stays at the same number.
 *
 * The two plans are used in turn: the one whose number is even, the one whose number is odd. The writer fills one only
 * when the reader has looked at the other (`looked_at`), and tells it by storing its number in `published`. What a killed
 * writer leaves half filled is never looked at.
 *
 * One writer, one reader. All is in memory that both see at any address: no pointers.
 */
#ifndef TRUNNION_PLAN_BUFFER_H
#define TRUNNION_PLAN_BUFFER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRUNNION_PLAN_AXES 9
#define TRUNNION_PLAN_ROWS 16384
#define TRUNNION_PLAN_FORMAT 0x54504c4e0001ull

/* One period: axis positions as the control counts them (mm, degrees), linear axes first, each kind in alphabetical
 * order, those the machine has not are 0; and the program's line. */
struct trunnion_row {
    double position[TRUNNION_PLAN_AXES];
    int64_t line;
};

struct trunnion_plan {
    uint64_t first;  /* number of rows[0] */
    uint64_t branch; /* number of the first row that the plan before has not, or has otherwise */
    uint64_t count;
    struct trunnion_row rows[TRUNNION_PLAN_ROWS];
};

struct trunnion_plans {
    uint64_t format; /* TRUNNION_PLAN_FORMAT, written last */
    uint64_t axes;
    double period_s;
    uint64_t published; /* number of the newest plan, from 1 on; 0: none yet. By the writer */
    uint64_t looked_at; /* the newest plan that the reader has looked at. By the reader, as all below */
    uint64_t in_use;    /* the plan that it plays */
    uint64_t next;      /* number of the row that it gives next */
    struct trunnion_plan plan[2];
};

/* What one reader knows; its own memory. */
struct trunnion_reader {
    struct trunnion_plans* plans;
    uint64_t looked_at, in_use, next;
};

/* Writer: makes plans empty. `plans` is zeroed memory. */
static inline void trunnion_plans_begin(struct trunnion_plans* plans, uint64_t axes, double period_s) {
    plans->axes = axes;
    plans->period_s = period_s;
    __atomic_store_n(&plans->format, TRUNNION_PLAN_FORMAT, __ATOMIC_RELEASE);
}

/* Writer: the plan to fill next; null while the reader has not looked at the newest one. */
static inline struct trunnion_plan* trunnion_plan_to_fill(struct trunnion_plans* plans) {
    const uint64_t published = __atomic_load_n(&plans->published, __ATOMIC_RELAXED);
    if (__atomic_load_n(&plans->looked_at, __ATOMIC_ACQUIRE) != published) return 0;
    return &plans->plan[(__atomic_load_n(&plans->in_use, __ATOMIC_RELAXED) + 1) & 1];
}

/* Writer: makes the plan that was filled the newest. Returns its number. After a refusal the plan in use keeps its place
 * and the refused one's is filled again, so that numbers go on by two. */
static inline uint64_t trunnion_publish(struct trunnion_plans* plans) {
    const uint64_t published = __atomic_load_n(&plans->published, __ATOMIC_RELAXED);
    const uint64_t in_use = __atomic_load_n(&plans->in_use, __ATOMIC_RELAXED);
    const uint64_t number = published + (((published ^ in_use) & 1) ? 2 : 1);
    __atomic_store_n(&plans->published, number, __ATOMIC_RELEASE);
    return number;
}

/* Reader: begins. Returns 0, or -1 where the memory is of another format. */
static inline int trunnion_reader_begin(struct trunnion_reader* reader, struct trunnion_plans* plans) {
    if (__atomic_load_n(&plans->format, __ATOMIC_ACQUIRE) != TRUNNION_PLAN_FORMAT) return -1;
    reader->plans = plans;
    reader->looked_at = reader->in_use = reader->next = 0;
    return 0;
}

/* Reader: looks whether there is a newer plan, and goes over to it if that can still be done. Every period. */
static inline void trunnion_look(struct trunnion_reader* reader) {
    struct trunnion_plans* const plans = reader->plans;
    const uint64_t newest = __atomic_load_n(&plans->published, __ATOMIC_ACQUIRE);
    const struct trunnion_plan* plan = &plans->plan[newest & 1];
    if (newest == reader->looked_at) return;
    if (plan->first <= reader->next && reader->next <= plan->branch && plan->count <= TRUNNION_PLAN_ROWS)
        reader->in_use = newest;
    reader->looked_at = newest;
    __atomic_store_n(&plans->in_use, reader->in_use, __ATOMIC_RELAXED);
    __atomic_store_n(&plans->looked_at, newest, __ATOMIC_RELEASE);
}

/* Reader: the row of this period; null: the plan is at its standstill, the axes stay where they are. The row is good
 * until the next call of trunnion_look(). */
static inline const struct trunnion_row* trunnion_next_row(struct trunnion_reader* reader) {
    const struct trunnion_plan* plan = &reader->plans->plan[reader->in_use & 1];
    if (reader->in_use == 0 || reader->next >= plan->first + plan->count) return 0;
    ++reader->next;
    __atomic_store_n(&reader->plans->next, reader->next, __ATOMIC_RELEASE);
    return &plan->rows[reader->next - 1 - plan->first];
}

#ifdef __cplusplus
}
#endif

#endif
