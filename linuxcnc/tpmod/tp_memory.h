/* SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-only
 *
 * The memory that LinuxCNC's module trunnion_tp and the process `trunnion serve` share. The module makes it.
 */
#ifndef TRUNNION_TP_MEMORY_H
#define TRUNNION_TP_MEMORY_H

#include "../plan_buffer.h"
#include "order_ring.h"

#define TRUNNION_TP_MEMORY "trunnion-tp"
#define TRUNNION_TP_FORMAT 0x545250540002ull

/* Rows of `plans` are poses as orders have them; `line` is the number of the move that a row lies on. */
struct trunnion_tp_memory {
    uint64_t format; /* TRUNNION_TP_FORMAT, written last */
    uint32_t told;   /* of orders.refused */
    struct trunnion_orders orders;
    struct trunnion_plans plans;
};

#endif
