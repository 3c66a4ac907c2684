// SPDX-License-Identifier: GPL-2.0-or-later
// Shared memory as LinuxCNC's userspace realtime has it: System V segments under LinuxCNC's keys, so that
// halcmd, halsampler and all other user-space HAL programs find HAL where they expect it.
#pragma once

#include <cstddef>
#include <vector>

namespace plumb::host {

inline constexpr int hal_memory_key = 0x48414c32;
inline constexpr int identity_memory_key = 0x48484c34;

class SharedMemory {
public:
    static constexpr int most_segments = 64;

    SharedMemory();
    ~SharedMemory();
    SharedMemory(const SharedMemory&) = delete;

    // Attaches the segment with this key, and creates it (all zero) when there is none. A second attach of
    // the same key counts up. Returns a handle from 0, or a negative errno.
    int attach(int key, std::size_t size);

    // Undoes one attach. The last one detaches, and removes the segment when no other process holds it.
    // Returns 0 or a negative errno.
    int detach(int handle);

    // Address of an attached segment, or nullptr.
    void* address(int handle) const;

    // Address of the segment with this key if this process has it attached, or nullptr.
    void* address_of_key(int key) const;

    // Address of the segment for which this process asked with this size, or nullptr.
    void* address_of_size(std::size_t size) const;

    // A number that no other HAL program on this HAL memory has. Returns it, or a negative errno. Each call
    // needs one give_identity_back(), which lets go of the memory that it is drawn from, not of the number.
    int take_identity();
    void give_identity_back();

private:
    struct Segment;
    std::vector<Segment> segments_;
    int identity_handle_ = -1;
};

// The one set of segments of this process: rtapi is a C interface without a handle.
SharedMemory& shared_memory();

}  // namespace plumb::host
