/* SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-only
 *
 * What a control's planner module asks of the process that plans for it: one line or arc after another, in memory that
 * both share. One writer (the servo thread), one reader; neither waits for the other, allocates or calls the system.
 *
 * Lengths mm, angles of rotary axes in degrees, speeds mm/s (moves that only turn: deg/s), as the control counts them.
 * Poses have nine numbers, in the order X Y Z A B C U V W.
 */
#ifndef TRUNNION_ORDER_RING_H
#define TRUNNION_ORDER_RING_H

#include <stdint.h>

#define TRUNNION_ORDER_CAPACITY 8192u /* a power of two */
#define TRUNNION_RUN_ALL UINT64_MAX

enum trunnion_order_kind {
    trunnion_order_begin = 1, /* what follows starts at rest at `end`; what is left of before is dropped */
    trunnion_order_line = 2,
    trunnion_order_arc = 3
};

/* How motion is to pass from a move to the next one. */
enum trunnion_order_joint { trunnion_joint_stop = 0, trunnion_joint_exact = 1, trunnion_joint_blend = 2 };

struct trunnion_order {
    uint64_t number; /* of the move, from 1; `begin`: that of the last move before it */
    uint32_t epoch;  /* counts the begins */
    int32_t kind;
    double end[9];
    double centre[3], normal[3];
    int32_t turn;       /* arcs: whole turns more, ≥ 0 counter-clockwise about the normal; < 0 clockwise, −1: none more */
    int32_t rapid;      /* 1: a traverse */
    int32_t joint;      /* to the move behind it */
    int32_t stop_first; /* 1: the machine stands before it until the control lets it go on */
    double tolerance;   /* of a blend; 0: none said */
    double speed;
    double tool_length; /* by which Z of the pose is above the tip */
};

/* The ring and what the control wishes at the moment. Every field has one writer. */
struct trunnion_orders {
    /* written by the control */
    volatile uint64_t written;    /* orders, ever */
    volatile uint64_t cycles;     /* servo periods, ever */
    volatile uint64_t last_order; /* cycles when the last one was written */
    volatile double feed_scale;   /* of the present motion: an override, 0 … */
    volatile double largest_speed; /* of the tip, mm/s, on every move that is not a turn alone; 0 or more */
    /* Move by move up to this one, each to a standstill at its end; 0: stand as soon as the limits allow;
       TRUNNION_RUN_ALL: all of them as they come. One word, so that a pause and a step cannot be mistaken. */
    volatile uint64_t run_through;
    volatile uint32_t aborted;    /* the epoch that is to be stopped for good; 0: none */
    volatile double period_s;
    volatile uint32_t closed;     /* 1: the control has ended */
    /* written by the planner */
    volatile uint64_t read;
    volatile uint64_t beat; /* changes while it lives */
    volatile uint32_t answered;      /* the epoch whose plans are published now: none of an earlier one any more */
    volatile uint32_t stopped;       /* the aborted epoch, once its plan to the standstill is published */
    volatile uint64_t done_through;  /* the last move whose end lies on the published plan */
    volatile uint32_t refused;       /* counts what could not be planned; `reason` says why */
    char reason[240];
    struct trunnion_order ring[TRUNNION_ORDER_CAPACITY];
};

/* 0: no room. */
static inline int trunnion_order_write(struct trunnion_orders *orders, const struct trunnion_order *order)
{
    uint64_t at = orders->written;
    if (at - __atomic_load_n(&orders->read, __ATOMIC_ACQUIRE) >= TRUNNION_ORDER_CAPACITY) return 0;
    orders->ring[at & (TRUNNION_ORDER_CAPACITY - 1)] = *order;
    orders->last_order = orders->cycles;
    __atomic_store_n(&orders->written, at + 1, __ATOMIC_RELEASE);
    return 1;
}

/* 0: none there. */
static inline int trunnion_order_read(struct trunnion_orders *orders, struct trunnion_order *order)
{
    uint64_t at = orders->read;
    if (at == __atomic_load_n(&orders->written, __ATOMIC_ACQUIRE)) return 0;
    *order = orders->ring[at & (TRUNNION_ORDER_CAPACITY - 1)];
    __atomic_store_n(&orders->read, at + 1, __ATOMIC_RELEASE);
    return 1;
}

#endif
