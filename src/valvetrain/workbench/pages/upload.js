// A file to send, or several together (many): chosen, sent at once, answered by an address to go to or by the reader's sentence.
export default {
  emits: ["done"],
  props: { label: String, hint: String, url: String, most: Number, field: String, many: Boolean },
  data() { return { sentence: "", busy: false }; },
  methods: {
    async send(event) {
      const files = Array.from(event.target.files);
      if (!files.length) { return; }
      this.sentence = "";
      const size = files.reduce((sum, one) => sum + one.size, 0);
      if (size > this.most) { this.sentence = files.map((one) => one.name).join(" and ") + ": larger than " + this.most / 1e6 + " MB; choose less."; return; }
      this.busy = true;
      try {
        const answer = await fetch(this.url + (this.many ? "" : (this.url.includes("?") ? "&" : "?") + "name=" + encodeURIComponent(files[0].name)),
          { method: "POST", body: this.many ? this.together(files) : files[0] });
        const said = answer.headers.get("content-type")?.includes("json") ? await answer.json() : { refusal: await answer.text() };
        if (said.refusal) { this.sentence = said.refusal; } else if (said.open) { window.location.assign(said.open); } else { this.$emit("done", said); }
      } catch (error) {
        this.sentence = "The file did not arrive; is the workbench still running?";
      }
      this.busy = false;
      event.target.value = "";
    },
    together(files) {
      const form = new FormData();
      files.forEach((one) => form.append("file", one, one.name));
      return form;
    },
  },
  template: `
<div class="labelled upload"><label :for="field">{{ label }}</label>
  <input type="file" :id="field" :multiple="many" @change="send" :aria-describedby="field + '-hint'" :aria-invalid="sentence ? 'true' : null">
  <p class="hint" :id="field + '-hint'">{{ busy ? "Reading …" : hint }}</p>
  <p v-if="sentence" class="refusal" role="alert">{{ sentence }}</p></div>`,
};
