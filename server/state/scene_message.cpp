// SPDX-License-Identifier: Apache-2.0
#include "server/state/scene_message.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cstdlib>

#include "proto/model/look.hpp"
#include "proto/model/preset.hpp"

namespace fanlight {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// The field of the message v1::Scene for a name of the scene table: "light.right_mm" is the field right_mm
/// of the message light, "mode" is a field of the scene itself. A test checks that table and message have the
/// same names, so that a missing name is a bug.
struct MessageField {
  const FieldDescriptor* group;  // null: the scene itself
  const FieldDescriptor* value;
};

MessageField message_field(std::string_view name) {
  const auto* scene = v1::Scene::descriptor();
  const std::size_t dot = name.find('.');
  const FieldDescriptor* group = nullptr;
  const auto* holder = scene;
  if (dot != std::string_view::npos) {
    group = scene->FindFieldByName(std::string(name.substr(0, dot)));
    if (group == nullptr) std::abort();
    holder = group->message_type();
  }
  const std::size_t begin = dot == std::string_view::npos ? 0 : dot + 1;
  const FieldDescriptor* value = holder->FindFieldByName(std::string(name.substr(begin)));
  if (value == nullptr) std::abort();
  return {group, value};
}

}  // namespace

void for_each_change(const v1::Scene& change,
                     const std::function<void(const SceneField&, std::variant<double, std::string>)>& each) {
  for (const SceneField& field : scene_fields()) {
    const auto [group, value] = message_field(field.name);
    const Message& holder = group == nullptr ? change : change.GetReflection()->GetMessage(change, group);
    const auto* reflection = holder.GetReflection();
    if (!reflection->HasField(holder, value)) continue;
    if (field.is_text()) {
      each(field, reflection->GetString(holder, value));
    } else if (value->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      each(field, reflection->GetDouble(holder, value));
    } else {
      each(field, static_cast<double>(reflection->GetUInt32(holder, value)));
    }
  }
}

void put_change(v1::Scene& change, const SceneField& field, const std::variant<double, std::string>& given) {
  const auto [group, value] = message_field(field.name);
  Message* holder = group == nullptr ? &change : change.GetReflection()->MutableMessage(&change, group);
  const auto* reflection = holder->GetReflection();
  if (field.is_text()) {
    reflection->SetString(holder, value, std::get<std::string>(given));
  } else if (value->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    reflection->SetDouble(holder, value, std::get<double>(given));
  } else {
    reflection->SetUInt32(holder, value, static_cast<std::uint32_t>(std::get<double>(given)));
  }
}

v1::Scene scene_message(const Scene& scene) {
  v1::Scene message;
  for (const SceneField& field : scene_fields()) {
    if (field.is_text()) {
      put_change(message, field, field.get_text(scene));
    } else {
      put_change(message, field, field.get(scene));
    }
  }
  return message;
}

Result<Scene> changed_scene(const Scene& scene, const v1::Scene& change, const SceneField** refused) {
  Scene changed = scene;
  Result<void> all;
  if (refused != nullptr) *refused = nullptr;
  for_each_change(change, [&](const SceneField& field, const std::variant<double, std::string>& value) {
    if (!all) return;
    const auto* number = std::get_if<double>(&value);
    all = number != nullptr ? set_field(changed, field, *number)
                            : set_field(changed, field, std::string_view(std::get<std::string>(value)));
    if (!all && refused != nullptr) *refused = &field;
  });
  if (!all) return all.error();
  if (auto whole = check(changed); !whole) return whole.error();
  return changed;
}

void describe(v1::Error& message, const Error& error, const SceneField* field) {
  message.set_message(error.message);
  if (field == nullptr) return;
  message.set_field(std::string(field->name));
  for (const std::string_view choice : field->choices) message.add_choices(std::string(choice));
  if (field->is_text() || !field->choices.empty()) return;
  message.set_minimum(field->minimum);
  message.set_maximum(field->maximum);
}

void add_presets(v1::Hello& hello) {
  for (const Preset& preset : presets()) {
    v1::Look& row = *hello.add_presets();
    row.set_name(std::string(preset.name));
    row.set_help(std::string(preset.help));
    Scene scene;
    apply_preset(scene, preset);
    for (const std::string_view name : preset_fields(preset)) {
      const SceneField& field = *find_scene_field(name);
      put_change(*row.mutable_scene(), field, field.get(scene));
    }
    for (const std::string_view name : found_fields(preset)) row.add_found_fields(std::string(name));
  }
}

void add_looks(v1::Hello& hello) {
  for (const Look& look : looks()) {
    v1::Look& row = *hello.add_looks();
    row.set_name(std::string(look.name));
    row.set_help(std::string(look.help));
    Scene scene;
    static_cast<void>(apply_look(scene, look.name));
    for (const Look::Value& value : look.values) {
      const SceneField& field = *find_scene_field(value.field);
      put_change(*row.mutable_scene(), field, field.get(scene));
    }
  }
}

void add_scene_fields(v1::Hello& hello) {
  for (const SceneField& field : scene_fields()) {
    v1::SceneField& row = *hello.add_fields();
    row.set_name(std::string(field.name));
    row.set_unit(std::string(field.unit));
    row.set_help(std::string(field.help));
    row.set_minimum(field.minimum);
    row.set_maximum(field.maximum);
    row.set_step(field.step);
    row.set_casts_rays(field.first_pass <= FirstPass::kCast);
    row.set_is_text(field.is_text());
    for (const std::string_view choice : field.choices) row.add_choices(std::string(choice));
  }
}

}  // namespace fanlight
