// SPDX-License-Identifier: Apache-2.0
/* Every malloc of the process, those of the libraries it loads included. */
#ifndef BCCSPLAT_TEST_COUNTED_HEAP_H
#define BCCSPLAT_TEST_COUNTED_HEAP_H

long heap_blocks(void); /* in use */
long heap_bytes(void);  /* in use */
long heap_peak(void);   /* bytes in use at most since the last heap_reset_peak() */
void heap_reset_peak(void);

#endif
