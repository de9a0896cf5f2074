#include "server/scene_message.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cstdlib>

namespace fanlight {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// A dotted name of the scene table in the message: "light.right_mm" is the field right_mm of the message
/// light, "mode" is a field of the scene itself. The schema and the table are one set of names, which a test
/// holds together; a name that is missing here is a bug.
struct MessageField {
  const FieldDescriptor* group;  // nullptr: the scene itself
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

v1::Scene scene_message(const Scene& scene) {
  v1::Scene message;
  for (const SceneField& field : scene_fields()) {
    const auto [group, value] = message_field(field.name);
    Message* holder = group == nullptr ? &message : message.GetReflection()->MutableMessage(&message, group);
    const auto* reflection = holder->GetReflection();
    if (field.is_text()) {
      reflection->SetString(holder, value, field.get_text(scene));
    } else if (value->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      reflection->SetDouble(holder, value, field.get(scene));
    } else {
      reflection->SetUInt32(holder, value, static_cast<std::uint32_t>(field.get(scene)));
    }
  }
  return message;
}

Result<Scene> changed_scene(const Scene& scene, const v1::Scene& change) {
  Scene changed = scene;
  for (const SceneField& field : scene_fields()) {
    const auto [group, value] = message_field(field.name);
    const Message& holder = group == nullptr ? change : change.GetReflection()->GetMessage(change, group);
    const auto* reflection = holder.GetReflection();
    if (!reflection->HasField(holder, value)) continue;
    if (field.is_text()) {
      if (auto set = set_field(changed, field, reflection->GetString(holder, value)); !set)
        return set.error();
      continue;
    }
    const double given = value->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE
                             ? reflection->GetDouble(holder, value)
                             : reflection->GetUInt32(holder, value);
    if (auto set = set_field(changed, field, given); !set) return set.error();
  }
  if (auto whole = check(changed); !whole) return whole.error();
  return changed;
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
