// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/server.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "hal/host/is_ready.hpp"
#include "hal/host/line_buffer.hpp"
#include "hal/host/messages.hpp"
#include "hal/host/rtapi_protocol.hpp"
#include "hal/socket_folder.hpp"

namespace plumb::host {

namespace {

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
}

constexpr std::size_t most_unsent = 1 << 20;  // bytes of answers
constexpr int most_pieces = 4;                // LineBuffer's, of a connection, before the next one's turn
constexpr int most_at_once = 64;              // requests of a connection, before the next one's turn

// Whether the other end is closed, while nothing is read from it.
bool hung_up(int descriptor) {
    pollfd state{descriptor, POLLRDHUP, 0};
    return poll(&state, 1, 0) > 0;
}

// The process at the other end; user and process are -1 if the system does not know.
ucred process_at(int descriptor) {
    ucred peer{-1, static_cast<uid_t>(-1), static_cast<gid_t>(-1)};
    socklen_t size = sizeof peer;
    getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size);
    return peer;
}

// Whether the other end is the same user's or root's, as is LinuxCNC's set-uid rtapi_app.
bool trusted(int descriptor) {
    const uid_t user = process_at(descriptor).uid;
    return user == geteuid() || user == 0;
}

// A socket that listens on `path`: as a file, or with `abstract` 1 in the abstract namespace, where rtapi_app
// of LinuxCNC 2.10 looks for it.
int listening(const std::string& path, std::size_t abstract) {
    const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path + abstract, path.c_str(), sizeof address.sun_path - 1 - abstract);
    if (listener < 0 || bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
        listen(listener, 64) != 0)
        fail("cannot listen on " + path);
    return listener;
}

}  // namespace

struct Server::Peer {
    Connection connection;
    int descriptor;
    bool is_client;       // the one that started this host
    bool frames = false;  // rtapi_app of LinuxCNC 2.10
    bool busy = false;    // a request is under way
    bool finish = false;  // close as soon as all is sent
    bool gone = false;
    LineBuffer received = {};
    std::string unsent = {};
    bool shown = false;  // the service has seen the request that waits
};

bool Server::takes_bytes(const Peer& peer) {
    return !peer.received.full();
}

// A connection that does not read its answers gets no more of them.
bool Server::takes_requests(const Peer& peer) {
    return !peer.busy && !peer.finish && !peer.gone && peer.unsent.size() < most_unsent;
}

Server::Server(Service& service, int control_descriptor)
    : service_(service), path_(folder_.path() + "/" + hal::socket_name) {
    listeners_ = {listening(path_, 0), listening(path_, 1)};
    admit_rtapi_app();

    if (control_descriptor >= 0) {
        fcntl(control_descriptor, F_SETFD, FD_CLOEXEC);
        fcntl(control_descriptor, F_SETFL, fcntl(control_descriptor, F_GETFL) | O_NONBLOCK);
        peers_.push_back({++last_, control_descriptor, true});
    }
}

Server::~Server() {
    for (Peer& peer : peers_) close(peer.descriptor);
    for (const int listener : listeners_) close(listener);
}

// When root runs LinuxCNC's rtapi_app, it opens the socket with the rights of the user in RTAPI_UID. That
// user may connect, and is not answered (see trusted()); the folder stays root's, so that nobody else can put
// a socket of his own in the place of this one. Where there is no such user (EINVAL, in a user namespace)
// rtapi_app has root's rights.
void Server::admit_rtapi_app() const {
    const char* const user = geteuid() == 0 ? std::getenv("RTAPI_UID") : nullptr;
    if (user == nullptr) return;
    const auto owner = static_cast<uid_t>(std::atoi(user));
    if (lchown(path_.c_str(), owner, static_cast<gid_t>(-1)) != 0 && errno != EINVAL)
        fail("cannot give " + path_ + " to user " + user);
    if (chmod(folder_.path().c_str(), 0711) != 0) fail("cannot open " + folder_.path());
}

void Server::add_to(std::vector<pollfd>& waits) const {
    for (const int listener : listeners_) waits.push_back({listener, POLLIN, 0});
    for (const Peer& peer : peers_)
        waits.push_back({peer.descriptor,
                         static_cast<short>((takes_bytes(peer) ? POLLIN : POLLRDHUP) |
                                            (peer.unsent.empty() ? 0 : POLLOUT)),
                         0});
}

void Server::accept_all(const std::vector<pollfd>& seen) {
    for (const int listener : listeners_) {
        while (is_ready(seen, listener)) {
            const int descriptor = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
            if (descriptor < 0) break;
            if (trusted(descriptor))
                peers_.push_back({++last_, descriptor, false, listener == listeners_.back()});
            else
                close(descriptor);
        }
    }
}

void Server::serve(const std::vector<pollfd>& seen) {
    accept_all(seen);
    // A service may close the connection that it answers, and a request may take a nested look at the
    // sockets.
    for (Peer& peer : peers_) {
        if (!peer.gone && is_ready(seen, peer.descriptor)) receive(peer);
        if (!peer.gone) take_requests(peer);
        if (!peer.gone) transmit(peer);
    }
    for (auto peer = peers_.begin(); peer != peers_.end();) {
        if (!peer->gone) {
            ++peer;
            continue;
        }
        close(peer->descriptor);
        client_gone_ = client_gone_ || peer->is_client;
        const Connection connection = peer->connection;
        peer = peers_.erase(peer);
        service_.closed(connection);
    }
}

void Server::receive(Peer& peer) {
    char buffer[LineBuffer::piece];
    if (!takes_bytes(peer) && hung_up(peer.descriptor)) peer.gone = true;
    for (int pieces = 0; pieces < most_pieces && takes_bytes(peer) && !peer.gone; ++pieces) {
        const ssize_t count = recv(peer.descriptor, buffer, sizeof buffer, MSG_DONTWAIT);
        if (count > 0) {
            peer.received.append({buffer, static_cast<std::size_t>(count)});
            if (peer.received.next() != LineBuffer::Next::nothing) return;
            continue;
        }
        if (count < 0 && errno == EINTR) continue;
        if (count == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) peer.gone = true;
        return;
    }
}

void Server::take_requests(Peer& peer) {
    const std::string_view waiting = peer.received.waiting();
    const bool text = !waiting.empty() && waiting[0] >= '0' && waiting[0] <= '9' && !peer.is_client;
    if (peer.frames || text) {
        if (!take_rtapi_request(peer)) peer.gone = true;
        return;
    }
    for (int count = 0; count < most_at_once && takes_requests(peer); ++count) {
        const LineBuffer::Next next = peer.received.next();
        if (next == LineBuffer::Next::nothing) return;
        take_request(peer, next == LineBuffer::Next::too_long);
    }
    if (!peer.busy || peer.shown || peer.received.next() != LineBuffer::Next::line) return;
    peer.shown = true;
    service_.control_request_waits(peer.received.look());
}

void Server::take_request(Peer& peer, bool too_long) {
    const std::string line = peer.received.take();
    peer.busy = true;
    if (too_long)
        service_.request_too_long(peer.connection);
    else
        service_.control_request(peer.connection, line);
}

bool Server::has_requests() {
    return std::any_of(peers_.begin(), peers_.end(), [](Peer& peer) {
        return takes_requests(peer) && peer.received.next() != LineBuffer::Next::nothing;
    });
}

bool Server::take_rtapi_request(Peer& peer) {
    try {
        if (peer.finish) return true;
        const std::string_view waiting = peer.received.waiting();
        const auto words = peer.frames ? words_of_frame(waiting) : words_of_text(waiting);
        if (!words) return true;
        peer.finish = true;
        const RtapiAnswer answer = service_.rtapi_command(*words, process_at(peer.descriptor).pid);
        peer.unsent = peer.frames ? frame_of(answer) : text_of(answer);
        return true;
    } catch (const std::runtime_error& error) {
        print_message(
            std::string("plumb-host: a request of rtapi_app's protocol is refused: ") + error.what() + "\n",
            true);
        return false;
    }
}

void Server::transmit(Peer& peer) {
    while (!peer.unsent.empty()) {
        const ssize_t count =
            ::send(peer.descriptor, peer.unsent.data(), peer.unsent.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (count > 0) {
            peer.unsent.erase(0, static_cast<std::size_t>(count));
            continue;
        }
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) peer.gone = true;
        return;
    }
    if (peer.finish) peer.gone = true;
}

Server::Peer* Server::find(Connection connection) {
    for (Peer& peer : peers_)
        if (peer.connection == connection) return &peer;
    return nullptr;
}

void Server::send(Connection to, const std::string& line) {
    Peer* const peer = find(to);
    if (peer == nullptr || peer->gone) return;
    peer->unsent += line + "\n";
    transmit(*peer);
}

void Server::answer(Connection to, const std::string& line) {
    send(to, line);
    if (Peer* const peer = find(to)) {
        peer->busy = false;
        peer->shown = false;
    }
}

void Server::flush() {
    for (int tries = 0; tries < 100; ++tries) {
        bool all_sent = true;
        for (Peer& peer : peers_) {
            if (!peer.gone) transmit(peer);
            all_sent = all_sent && (peer.gone || peer.unsent.empty());
        }
        if (all_sent) return;
        poll(nullptr, 0, 10);
    }
}

}  // namespace plumb::host
