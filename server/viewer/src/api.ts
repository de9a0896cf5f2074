// SPDX-License-Identifier: Apache-2.0
// Requests to the server beside the stream, with the token of this tab.
import { keptToken } from "./login_form";

/** `json`: is posted; without it, the address is read. Throws the server's sentence where it refuses. */
export async function callApi(path: string, json?: object): Promise<Response> {
  const headers = new Headers();
  const token = keptToken();
  if (token) headers.set("Authorization", `Bearer ${token}`);
  if (json) headers.set("Content-Type", "application/json");
  const response = await fetch(path, { headers, ...(json && { method: "POST", body: JSON.stringify(json) }) });
  if (!response.ok) throw new Error(await sentenceOf(response));
  return response;
}

async function sentenceOf(response: Response): Promise<string> {
  const text = await response.text();
  try {
    return (JSON.parse(text) as { detail: string }).detail;
  } catch {
    return text.trim() || `the server answers ${response.status}`;
  }
}
