// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/can_sensor/can_frame.hpp"
#include "components/io/sensor/waiting.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

namespace plumb {

// The reading of a socket: a frame of data, or the class of an error frame.
struct CanReceived {
    CanFrame frame;
    std::uint32_t error = 0;    // CAN_ERR_... of an error frame, else 0
    double time = 0;            // s, of seconds_now(): when the kernel received it
    std::uint32_t dropped = 0;  // frames that the socket has lost so far
};

// A raw socket of one interface, which receives frames that match and all error frames. Failures are
// std::system_error.
class CanSocket {
public:
    CanSocket() = default;

    CanSocket(const std::string& interface, const std::vector<CanMatch>& matches)
        : descriptor_(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)) {
        if (!descriptor_) fail("SocketCAN");
        index_ = static_cast<int>(if_nametoindex(interface.c_str()));
        if (index_ == 0) throw std::system_error(ENODEV, std::generic_category(), interface);
        std::vector<can_filter> filters;
        for (const CanMatch& match : matches) {
            // A filter without the two flags also takes frames of the other length, and remote requests.
            can_filter filter{};
            filter.can_id = match.id | (match.extended ? CAN_EFF_FLAG : 0);
            filter.can_mask = match.mask | CAN_EFF_FLAG | CAN_RTR_FLAG;
            filters.push_back(filter);
        }
        const int yes = 1;
        const int buffer = 1 << 20;  // bytes; the system may grant less
        setsockopt(number(), SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
        const can_err_mask_t errors = CAN_ERR_MASK;
        set(SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), filters.size() * sizeof(can_filter));
        set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
        set(SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
        set(SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes);
        setsockopt(number(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &yes, sizeof yes);  // old kernels have none
        sockaddr_can address{};
        address.can_family = AF_CAN;
        address.can_ifindex = index_;
        if (bind(number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fail(interface);
    }

    bool is_open() const noexcept { return static_cast<bool>(descriptor_); }
    int number() const noexcept { return descriptor_.number(); }
    void close() noexcept { descriptor_.close(); }

    enum class State { up, down, gone };

    // Of the interface, which may be another one of the same name.
    State state(const std::string& interface) const {
        ifreq request{};
        std::strncpy(request.ifr_name, interface.c_str(), IFNAMSIZ - 1);
        if (ioctl(number(), SIOCGIFINDEX, &request) != 0 || request.ifr_ifindex != index_) return State::gone;
        if (ioctl(number(), SIOCGIFFLAGS, &request) != 0) return State::gone;
        return (request.ifr_flags & IFF_UP) != 0 ? State::up : State::down;
    }

    // Before a run of receive(): frames that come meanwhile get this time.
    void look_at_clocks() noexcept {
        timespec wall{};
        clock_gettime(CLOCK_REALTIME, &wall);
        wall_now_ = seconds(wall);
        now_ = seconds_now();
    }

    // False if nothing has come.
    bool receive(CanReceived& received) {
        canfd_frame raw{};
        alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t))];
        iovec vector{&raw, sizeof raw};
        msghdr message{};
        message.msg_iov = &vector;
        message.msg_iovlen = 1;
        message.msg_control = control;
        message.msg_controllen = sizeof control;
        const ssize_t size = recvmsg(number(), &message, 0);
        if (size < 0 && (errno == EAGAIN || errno == EINTR)) return false;
        if (size < 0) fail("");
        received = {};
        received.time = now_;
        for (cmsghdr* each = CMSG_FIRSTHDR(&message); each; each = CMSG_NXTHDR(&message, each)) {
            if (each->cmsg_level != SOL_SOCKET) continue;
            if (each->cmsg_type == SO_TIMESTAMPNS) {
                timespec stamp{};
                std::memcpy(&stamp, CMSG_DATA(each), sizeof stamp);
                // A clock that was set back in between does not bring a frame into the future.
                received.time -= std::max(wall_now_ - seconds(stamp), 0.0);
            } else if (each->cmsg_type == SO_RXQ_OVFL) {
                std::memcpy(&received.dropped, CMSG_DATA(each), sizeof received.dropped);
            }
        }
        if (size != CAN_MTU && size != CANFD_MTU) return true;  // an empty frame, which matches nothing
        if ((raw.can_id & CAN_ERR_FLAG) != 0) {
            received.error = raw.can_id & CAN_ERR_MASK;
            return true;
        }
        received.frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
        received.frame.id = raw.can_id & (received.frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
        received.frame.size = raw.len <= 64 ? raw.len : 0;
        std::memcpy(received.frame.bytes, raw.data, received.frame.size);
        return true;
    }

    // A classic frame. False if the interface cannot take it now.
    bool send(const CanFrame& frame) {
        can_frame raw{};
        raw.can_id = frame.id;
        raw.can_dlc = static_cast<std::uint8_t>(frame.size);
        std::memcpy(raw.data, frame.bytes, frame.size);
        return write(number(), &raw, sizeof raw) == sizeof raw;
    }

private:
    [[noreturn]] static void fail(const std::string& what) {
        throw std::system_error(errno, std::generic_category(), what);
    }

    void set(int level, int option, const void* value, std::size_t size) const {
        if (setsockopt(number(), level, option, value, static_cast<socklen_t>(size)) != 0) fail("setsockopt");
    }

    static double seconds(const timespec& time) noexcept {
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }

    Descriptor descriptor_;
    int index_ = 0;
    double now_ = 0, wall_now_ = 0;  // s, of both clocks
};

}  // namespace plumb
