// A file to send: chosen, sent at once, answered by an address to go to or by the reader's sentence.
export default {
  emits: ["done"],
  props: { label: String, hint: String, url: String, accept: String, most: Number, field: String },
  data() { return { sentence: "", busy: false }; },
  methods: {
    async send(event) {
      const file = event.target.files[0];
      if (!file) { return; }
      this.sentence = "";
      if (file.size > this.most) { this.sentence = file.name + " is larger than " + this.most / 1e6 + " MB; choose a smaller file."; return; }
      this.busy = true;
      try {
        const answer = await fetch(this.url + (this.url.includes("?") ? "&" : "?") + "name=" + encodeURIComponent(file.name), { method: "POST", body: file });
        const said = answer.headers.get("content-type")?.includes("json") ? await answer.json() : { refusal: await answer.text() };
        if (said.refusal) { this.sentence = said.refusal; } else if (said.open) { window.location.assign(said.open); } else { this.$emit("done", said); }
      } catch (error) {
        this.sentence = "The file did not arrive; is the workbench still running?";
      }
      this.busy = false;
      event.target.value = "";
    },
  },
  template: `
<div class="labelled upload"><label :for="field">{{ label }}</label>
  <input type="file" :id="field" :accept="accept" @change="send" :aria-describedby="field + '-hint'" :aria-invalid="sentence ? 'true' : null">
  <p class="hint" :id="field + '-hint'">{{ busy ? "Reading …" : hint }}</p>
  <p v-if="sentence" class="refusal" role="alert">{{ sentence }}</p></div>`,
};
