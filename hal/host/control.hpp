// SPDX-License-Identifier: GPL-2.0-or-later
// Carries out the requests of clients and rtapi_app. A control request is a JSON object with the key "do";
// the answer is {"ok":true,...}, or {"ok":false,"error":"one sentence"}. Times are whole nanoseconds;
// numbers that are not finite travel as the strings "nan", "inf" and "-inf". A request that is longer than
// 1 MiB (LineBuffer), or has more than 32 lists and objects within each other, is refused.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hal/host/modules.hpp"
#include "hal/host/pace.hpp"
#include "hal/host/private_files.hpp"
#include "hal/host/programs.hpp"
#include "hal/host/server.hpp"
#include "hal/host/timeline.hpp"

namespace plumb::host {

class Request;

class Control final : public Server::Service {
public:
    struct Settings {
        std::vector<std::string> module_folders;
        std::vector<std::string> module_options;
        bool namespaces;
        int process;  // number of this process as its client sees it
        int control_descriptor;
        bool devices = false;  // leave the computer's devices to the program
        std::string models;    // the file of Models; empty: none
        double speed = 0.0;    // of virtual time; 0: it moves when a client lets it run
    };

    explicit Control(Settings settings);

    // Ends the programs, then unloads the modules.
    ~Control();

    // Serves until a client or rtapi_app asks for the end, the client is gone, or `end_descriptor`
    // becomes readable.
    void serve(int end_descriptor);

    // Runs a program on the host's terminal, with files of its own where there are namespaces, and serves
    // until it has ended. When `end_descriptor` becomes readable, asks the program to end, and waits a
    // while for it. Returns its exit status. Throws ProgramNotFound, or std::runtime_error if its files
    // cannot be made.
    int run_program(const std::vector<std::string>& words, int end_descriptor);

    RtapiAnswer rtapi_command(const std::vector<std::string>& words, pid_t process) override;
    void control_request(Server::Connection from, const std::string& line) override;
    void request_too_long(Server::Connection from) override;
    void control_request_waits(const std::string& line) override;
    void closed(Server::Connection connection) override;

private:
    using Json = nlohmann::json;

    std::optional<Json> carry_out(Server::Connection from, const Request& request);
    Json hello() const;
    void halcmd(Server::Connection from, const Request& request);
    Json get(const Request& request);
    Json set(const Request& request);
    void run(Server::Connection from, const Request& request);
    Json record(const Request& request);
    Json replay(const Request& request);
    Json expect(const Request& request);
    Json violations();
    Json guard();
    Json programs();

    void set_value(const std::string& name, const Json& value);
    // Whether it is an input, or a parameter that can be written.
    bool settable(const std::string& name);
    void list_settable();
    void make_replayable(const std::string& name, bool override_writer);
    std::string signal_of(const std::string& pin);
    std::string writer_of(const std::string& signal);
    void need_hal();
    void start_program(const std::vector<std::string>& words);
    void report_lost_pace(std::chrono::nanoseconds real) const;
    void attend(int end_descriptor);
    std::chrono::nanoseconds idle_time();
    void let_time_pass();
    std::chrono::nanoseconds rest() const;
    void unload_all();
    void let_unloaded_go();
    void show_progress();
    void move(const std::function<void()>& timeline_action);  // answers the runner when the run has ended
    void stop();
    void answer(Server::Connection to, const Json& answer);

    Settings settings_;
    Programs programs_;
    Modules modules_;
    Timeline timeline_;
    std::optional<Pace> pace_;
    std::chrono::steady_clock::time_point rest_until_;  // in a paced run
    std::chrono::steady_clock::time_point last_look_;   // at the names that are watched in a paced run
    Server server_;
    std::optional<PrivateFiles> files_;
    std::optional<Server::Connection> runner_;  // the connection that waits for the end of the run
    std::chrono::steady_clock::time_point last_progress_, answered_;
    std::set<std::string> settable_;  // inputs, and parameters that can be written, as halcmd lists them
    unsigned long settable_at_ = 0;   // state of HAL for which that holds
    bool realtime_ = false;           // LinuxCNC 2.10 asks whether it is started, which a host always is
    bool end_ = false;
    bool end_by_signal_ = false;
};

}  // namespace plumb::host
