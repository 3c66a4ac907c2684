// SPDX-License-Identifier: GPL-2.0-or-later
// For scripts/try-arm64: shared memory that was let go is attached at its address again.
//
// halcmd leaves HAL before it starts a program and enters it again, and LinuxCNC's rtapi_init() keeps the first address of its
// smallest block all the time (uuid_shmem_base). Linux gives the same address again, qemu-user another, and halcmd crashes.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdbool.h>
#include <sys/shm.h>

enum { MOST = 16 };
static struct {
    const void *address;
    size_t size;
    bool attached;
} blocks[MOST];

void *shmat(int id, const void *address, int flags) {
    void *(*const attach)(int, const void *, int) = dlsym(RTLD_NEXT, "shmat");
    struct shmid_ds about;
    if (address || shmctl(id, IPC_STAT, &about)) return attach(id, address, flags);
    for (int i = 0; i < MOST; ++i) {
        if (blocks[i].attached || (blocks[i].address && blocks[i].size != about.shm_segsz)) continue;
        void *const got = attach(id, blocks[i].address, flags);
        if (got == (void *)-1) return got;
        blocks[i].address = got;
        blocks[i].size = about.shm_segsz;
        blocks[i].attached = true;
        return got;
    }
    return attach(id, address, flags);
}

int shmdt(const void *address) {
    int (*const detach)(const void *) = dlsym(RTLD_NEXT, "shmdt");
    for (int i = 0; i < MOST; ++i)
        if (blocks[i].address == address) blocks[i].attached = false;
    return detach(address);
}
