// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_commands.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "proto/base/printable.hpp"
#include "server/state/scene_json.hpp"

namespace fanlight {

namespace {

using nlohmann::json;

/// A CommandReply with parameters.
IgtlCommands::Reply reply(std::string_view name, const std::string& trouble,
                          const IgtlCommands::Values& parameters = {}) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("CommandReply");
  root.append_attribute("Name").set_value(printable(name).c_str());
  root.append_attribute("Status").set_value(trouble.empty() ? "SUCCESS" : "FAIL");
  root.append_attribute("Message").set_value(trouble.c_str());
  for (const auto& [parameter, value] : parameters) {
    pugi::xml_node node = root.append_child("Parameter");
    node.append_attribute("Name").set_value(parameter.c_str());
    node.append_attribute("Value").set_value(value.c_str());
  }
  std::ostringstream text;
  document.save(text, "", pugi::format_raw | pugi::format_no_declaration);
  return {.done = trouble.empty(), .xml = text.str()};
}

/// A number as JSON has it, or a text: the name of a choice.
json json_value(const std::string& text) {
  const json number = json::parse(text, nullptr, false);
  return number.is_number() ? number : json(text);
}

std::string text_of(const nlohmann::ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// "light.up_mm" of {"light": {"up_mm": ...}}. Precondition: the name of a field.
const nlohmann::ordered_json& value_of(const nlohmann::ordered_json& scene, const std::string& name) {
  const std::size_t dot = name.find('.');
  return dot == std::string::npos ? scene.at(name) : scene.at(name.substr(0, dot)).at(name.substr(dot + 1));
}

}  // namespace

std::string IgtlCommands::refusal(const std::string& why) {
  return reply("", why).xml;
}

IgtlCommands::Reply IgtlCommands::carry_out(std::string_view name, std::string_view xml,
                                            const Principal& principal) {
  constexpr const char* kExpected =
      "expected <Command Name=\"SetParameter\"> or GetParameter, with <Parameter Name=... Value=.../>";
  const auto refused = [&](std::string_view command, const std::string& trouble) {
    dependencies_.state.counters.igtl_command_refusals.add();
    return reply(command, trouble);
  };
  pugi::xml_document document;
  // No entities beyond those of XML itself, and no document type, are read.
  const auto parsed = document.load_buffer(xml.data(), xml.size(), pugi::parse_default);
  const pugi::xml_node command = document.child("Command");
  if (!parsed || !command) return refused(name, fmt::format("the command is no XML, {}", kExpected));
  const std::string wanted = command.attribute("Name").as_string(std::string(name).c_str());
  Values parameters;
  for (const pugi::xml_node parameter : command.children("Parameter"))
    parameters.emplace_back(parameter.attribute("Name").as_string(),
                            parameter.attribute("Value").as_string());
  if (wanted == "GetParameter") {
    std::vector<std::string> names;
    names.reserve(parameters.size());
    for (const auto& [parameter, value] : parameters) names.push_back(parameter);
    return get(names);
  }
  if (wanted != "SetParameter")
    return refused(wanted, fmt::format("there is no command {}, {}", printable(wanted), kExpected));
  if (parameters.empty())
    return refused(wanted, "there is no Parameter, expected one with a Name and a Value");
  return set(parameters, principal);
}

IgtlCommands::Reply IgtlCommands::get(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (find_scene_field(name) != nullptr) continue;
    dependencies_.state.counters.igtl_command_refusals.add();
    return reply("GetParameter", no_scene_field(name).message);
  }
  if (!names.empty()) return reply("GetParameter", "", in_force(names));
  std::vector<std::string> all;
  for (const SceneField& field : scene_fields()) all.emplace_back(field.name);
  return reply("GetParameter", "", in_force(all));
}

IgtlCommands::Values IgtlCommands::in_force(const std::vector<std::string>& names) const {
  const nlohmann::ordered_json scene = scene_json(dependencies_.state.scene_store.in_force().scene);
  Values values;
  for (const std::string& name : names) values.emplace_back(name, text_of(value_of(scene, name)));
  return values;
}

IgtlCommands::Reply IgtlCommands::set(const Values& values, const Principal& principal) {
  json change = json::object();
  std::vector<std::string> names;
  for (const auto& [name, value] : values) {
    change[name] = json_value(value);
    names.push_back(name);
  }
  SessionlessRequester client(dependencies_.audit, principal);
  const auto answered = [&](const CommandResult& result) {
    if (result) return reply("SetParameter", "", in_force(names));
    dependencies_.state.counters.igtl_command_refusals.add();
    return reply("SetParameter", result.error.message);
  };
  const auto fields = scene_change_from_json(change);
  if (!fields)
    return answered(dependencies_.commands.reject(client.requester(), ChangeScene(), fields.error(), change));
  Reply answer;
  dependencies_.commands.execute(client.requester(), ChangeScene{*fields},
                                 [&](const CommandResult& result) { answer = answered(result); });
  return answer;
}

}  // namespace fanlight
