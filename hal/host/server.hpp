// SPDX-License-Identifier: GPL-2.0-or-later
// The host's socket and the descriptor that its client passed on. A connection that begins with a digit
// speaks the text protocol of rtapi_app of LinuxCNC 2.9; one that begins with '{' speaks the control
// protocol, a JSON object a line. A second socket, of the same name in the abstract namespace, is for
// rtapi_app of LinuxCNC 2.10, which sends binary frames. Requests of one connection are taken one after the
// other; connections do not wait for each other. Requests are read as they are taken, and taken as their
// answers are read: no connection fills the memory, or keeps the others waiting.
#pragma once

#include <poll.h>

#include <list>
#include <string>
#include <vector>

#include "hal/host/host_folder.hpp"
#include "hal/host/rtapi_protocol.hpp"

namespace plumb::host {

class Server {
public:
    using Connection = unsigned long;

    // Who answers.
    class Service {
    public:
        // Carries out a command of rtapi_app for a process; returns its result.
        virtual RtapiAnswer rtapi_command(const std::vector<std::string>& words, pid_t process) = 0;

        // Takes a request. The answer may come later, by Server::answer().
        virtual void control_request(Connection from, const std::string& line) = 0;

        // Takes the place of a request that is longer than LineBuffer::longest, and is dropped. It too gets
        // an answer.
        virtual void request_too_long(Connection from) = 0;

        // Sees the request that comes next, while it waits for the end of the present one on its connection.
        virtual void control_request_waits(const std::string& line) = 0;

        // The connection is gone.
        virtual void closed(Connection connection) = 0;

    protected:
        ~Service() = default;
    };

    // Listens on a new socket in a new private folder, and, when `control_descriptor` is not negative,
    // serves that too. Throws std::runtime_error when the socket cannot be made.
    Server(Service& service, int control_descriptor);

    // Removes the socket and its folder.
    ~Server();
    Server(const Server&) = delete;

    // The path of the socket: RTAPI_FIFO_PATH of all programs that are to find this host.
    const std::string& path() const { return path_; }

    // Appends the descriptors that serve() waits for.
    void add_to(std::vector<pollfd>& waits) const;

    // Accepts connections, reads, carries out and answers all requests so far. `seen` is what poll() told of
    // the descriptors of add_to(). Never waits.
    void serve(const std::vector<pollfd>& seen);

    // Whether serve() has something to do although nothing new has come: a request has waited for another
    // one.
    bool has_requests();

    // Sends a line; it does not end the request.
    void send(Connection to, const std::string& line);

    // Sends the answer and goes on to the connection's next request.
    void answer(Connection to, const std::string& line);

    // Whether the client that passed its descriptor on has closed it.
    bool client_gone() const { return client_gone_; }

    // Waits until all answers are sent, for a second at most.
    void flush();

private:
    struct Peer;

    void admit_rtapi_app() const;
    void accept_all(const std::vector<pollfd>& seen);
    static bool takes_bytes(const Peer& peer);
    static bool takes_requests(const Peer& peer);
    void receive(Peer& peer);
    void take_requests(Peer& peer);
    void take_request(Peer& peer, bool too_long);
    bool take_rtapi_request(Peer& peer);
    void transmit(Peer& peer);
    Peer* find(Connection connection);

    Service& service_;
    HostFolder folder_;
    std::string path_;
    std::vector<int> listeners_;  // the file, and the abstract one
    std::list<Peer> peers_;
    Connection last_ = 0;
    bool client_gone_ = false;
};

}  // namespace plumb::host
