// SPDX-License-Identifier: Apache-2.0
// build.mjs makes a text of a shader in shaders/web, with all that it includes.
declare module "*.frag" {
  const text: string;
  export default text;
}
declare module "*.vert" {
  const text: string;
  export default text;
}
